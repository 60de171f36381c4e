"""Applied modifiers (7.3.12.4): instances of their own, beside the modified behavior.

Their parameters get values together with those of the invocation, since a modifier may constrain it. An argument
is a constraint on its parameter: equality to a value, or membership in a range. A repeated invocation gets new
values; the parameters of its modifiers stay, and their variables restart.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from typing import TypeAlias, cast

from seoro.deferred import dataclass
from seoro.lang import frozen
from seoro.lang import plan as plan_
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.environment import Calls, Deferred, Environment, Seed
from seoro.runtime.values.values import Actor, Fields, HasFields, Struct, Value

_APPLIED = "applied()"  # binding of a modifier around its arguments; not a name of the language
_IT = "it"

OF_BLOCK, OF_TYPE = (-2,), (-1,)  # positions of modifications, before the body, which is member 0


class Attached(frozen.Value):
    """A modifier of an instance, whose values are chosen with those of the instance.

    Args:
        structure: Its structure.
        environment: Its environment; its instance is the modifier.
        given: Values that it already has.
        constraints: Constraints from its arguments.
        around: Environment of the arguments.
    """

    structure: plan_.Structure
    environment: Environment
    given: Mapping[str, Value]
    constraints: tuple[plan_.ConstraintMember, ...]
    around: Environment


@dataclass(eq=False)
class Applied:
    """An applied modifier.

    Args:
        plan: The application.
        modifier: The modifier.
        around: Environment of its arguments.
        inside: Its own environment.
        bindings: Bindings in that.
        modifiers: Modifiers that it applies in turn, the outermost first.
        position: Its position among the modifications of one behavior.
        holder: Name of the struct or actor that it is a member of; otherwise empty.
        is_entered: Whether the modified behavior has run before.
    """

    plan: plan_.ModifierApplication
    modifier: plan_.Modifier
    around: Environment
    inside: Environment
    bindings: dict[str, Value | HasFields]
    modifiers: tuple[Applied | plan_.Override, ...]
    position: tuple[int, ...]
    holder: str = ""
    is_entered: bool = field(default=False, init=False)

    @property
    def fields(self) -> Fields:
        """Its parameters and variables."""
        return cast(Fields, self.inside.instance.fields)

    @property
    def name(self) -> str:
        """Name of this application among the modifications of one behavior."""
        name, actor = self.modifier.name.rpartition(".")[2], self.plan.actor
        holder = self.holder or (
            actor.span.text if actor is not None and not isinstance(actor, plan_.Binding) else ""
        )
        number = ".".join(map(str, self.position[2 if self.holder else 1 :]))
        return f"{holder}.{name}[{number}]" if holder else f"{name}[{number}]"

    def rebind(self, it: HasFields) -> None:
        """Bind `it` to another instance, for the next run of the modified behavior."""
        self.bindings[_IT] = it

    @property
    def has_values(self) -> bool:
        """Whether its values are chosen."""
        return self.modifier.structure.fields.keys() <= self.fields.keys()

    def attached(self, calls: Calls) -> Attached:
        """Return the structure and constraints for choosing its values.

        Args:
            calls: Results of external methods.
        """
        arguments, ranges = (self.plan.arguments, self.plan.ranges) if not self.has_values else ((), ())
        applied = plan_.Binding(_APPLIED, self.plan.span)
        constraints: list[plan_.Constraint] = []
        for name, value in arguments:
            parameter = plan_.Member(applied, name, value.span)
            constraints.append(
                plan_.Constraint(plan_.Compare("==", parameter, value, value.span), False, value.span)
            )
        for name, value in ranges:
            parameter = plan_.Member(applied, name, value.span)
            constraints.append(plan_.Constraint(plan_.Contains(parameter, value, value.span), False, value.span))
        around = {**self.around.bindings, _APPLIED: self.inside.instance}
        return Attached(
            structure=self.modifier.structure,
            environment=replace(self.inside, calls=calls),
            given=dict(self.fields),
            constraints=tuple(constraints),
            around=replace(self.around, bindings=around, calls=calls),
        )


Modifying: TypeAlias = plan_.Until | Applied | plan_.Override
"""Modification of a whole behavior, with modifiers as instances."""


def apply(
    modifications: Iterable[plan_.Modification],
    modifiers: Mapping[str, plan_.Modifier],
    around: Environment,
    it: HasFields,
    position: tuple[int, ...],
) -> tuple[Modifying, ...]:
    """Create the modifications of a behavior, without values.

    Args:
        modifications: Modifications in the plan.
        modifiers: Modifiers by name.
        around: Environment of the modifications.
        it: The modified instance.
        position: Position of all of them among the modifications of one behavior.
    """
    return tuple(
        _apply_one(each, modifiers, around, it, (*position, number))
        if isinstance(each, plan_.ModifierApplication)
        else each
        for number, each in enumerate(modifications)
    )


def _apply_one(
    application: plan_.ModifierApplication,
    modifiers: Mapping[str, plan_.Modifier],
    around: Environment,
    it: HasFields,
    position: tuple[int, ...],
) -> Applied:
    modifier = modifiers[application.modifier]
    bindings: dict[str, Value | HasFields] = {_IT: it}
    if application.actor is not None:
        bindings["actor"] = cast(Value, Deferred(application.actor, around))  # stands for a value
    inside = Environment(
        Instance(modifier.name, Fields(), modifier, bindings, around.outermost),
        around.plan,
        bindings,
        modifier.name,
        around.outermost,
        seed=Seed(around.seed, f"{position[-1]} {modifier.name}"),
        run=around.run,
    )
    nested = cast(tuple[Applied | plan_.Override, ...], apply(modifier.modifiers, modifiers, inside, it, position))
    return Applied(application, modifier, around, inside, bindings, nested, position)


def with_nested(modifications: Iterable[Modifying]) -> Iterator[Applied]:
    """Yield all applied modifiers, outer ones first."""
    for modification in modifications:
        if isinstance(modification, Applied):
            yield modification
            yield from with_nested(modification.modifiers)


def modifiers_of(holder: Struct | Actor) -> tuple[Applied, ...]:
    """Return the applied modifiers that are members of the types of a value."""
    return tuple(each for each in holder.modifiers if isinstance(each, Applied))
