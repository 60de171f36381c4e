"""Modifiers as they are applied (7.3.12.4): instances of their own, beside what they modify.

Their parameters get their values together with those of what is invoked, since a modifier may constrain it. An
argument is a constraint on its parameter: that it is equal to a value, or in a range. What is carried out again
gets new values; the parameters of its modifiers stay, and their variables begin anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias, cast

from seoro.lang.plan import (
    Binding,
    Compare,
    Constraint,
    Contains,
    Member,
    Modification,
    Modifier,
    ModifierApplication,
    Override,
    Structures,
    Until,
)
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.environment import Calls, Deferred, Environment, Seed
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instances import Instance
from seoro.runtime.values import Actor, HasFields, Value

if TYPE_CHECKING:
    from seoro.runtime.choose.request import Attached

_APPLIED = "applied()"  # what a modifier is bound to around its arguments; no name of the language
_IT = "it"


@dataclass(eq=False)
class Applied:
    """A modifier that is applied.

    Args:
        plan: The application.
        modifier: The modifier.
        around: The scope of its arguments.
        inside: Its own scope.
        bindings: What names are bound to in it.
        modifiers: The modifiers that it applies in turn, the outermost first.
        position: Where it is among all that modifies one behavior.
        holder: What a struct or an actor is called of which it is a member; empty for all else.
    """

    plan: ModifierApplication
    modifier: Modifier
    around: Environment
    inside: Environment
    bindings: dict[str, Value | HasFields]
    modifiers: tuple[Applied | Override, ...]
    position: tuple[int, ...]
    holder: str = ""
    _is_entered: bool = field(default=False, init=False)

    @property
    def fields(self) -> Fields:
        """Its parameters and variables."""
        return cast(Fields, self.inside.instance.fields)

    @property
    def actor(self) -> Actor | None:
        """The actor that it is applied to."""
        actor = evaluate(self.plan.actor, self.around) if self.plan.actor is not None else None
        assert actor is None or isinstance(actor, Actor)
        return actor

    @property
    def name(self) -> str:
        """What people call this application, among all that modifies one behavior."""
        name, actor = self.modifier.name.rpartition(".")[2], self.plan.actor
        holder = self.holder or (actor.span.text if actor is not None and not isinstance(actor, Binding) else "")
        number = ".".join(map(str, self.position[2 if self.holder else 1 :]))
        return f"{holder}.{name}[{number}]" if holder else f"{name}[{number}]"

    def turn_to(self, it: HasFields) -> None:
        """What it modifies is carried out again, by another instance."""
        self.bindings[_IT] = it

    @property
    def has_values(self) -> bool:
        """Whether it has got its values."""
        return self.modifier.structure.fields.keys() <= self.fields.keys()

    @property
    def is_plain(self) -> bool:
        """Whether nothing has to be chosen for it, or for what it modifies because of it."""
        structure = self.modifier.structure
        if self.has_values:
            return structure.is_plain
        given: dict[str, Value] = {name: True for name, _ in self.plan.arguments}
        return not self.plan.ranges and is_plain(structure, given)

    def fill(self, structures: Structures) -> None:
        """Give it its values, where nothing has to be chosen.

        Raises:
            EvaluationError: An argument or a default has no value.
        """
        if not self.has_values:
            for name, value in self.plan.arguments:
                self.fields[name] = evaluate(value, self.around)
            fill(self.fields, self.modifier.structure, structures, self.inside, evaluate)

    def enter(self, path: str, structures: Structures) -> Instance:
        """An instance of it for each time that what it modifies is carried out.

        Args:
            path: Its position, for people.
            structures: The structures of all types.

        Raises:
            EvaluationError: A variable has no value.
        """
        structure, fields = self.modifier.structure, self.fields
        if self._is_entered:
            fields = Fields()
            parameters = (declared.name for declared in structure.fields.values() if not declared.is_variable)
            fields.update((name, self.fields[name]) for name in parameters)
        instance = Instance(path, fields, self.modifier, self.bindings, self.inside.scenario)
        if self._is_entered:
            fill(fields, structure, structures, replace(self.inside, instance=instance), evaluate)
        self._is_entered = True
        return instance

    def attached(self, calls: Calls) -> Attached:
        """What is to be chosen for it, or because of it.

        Args:
            calls: What external methods have returned.
        """
        from seoro.runtime.choose.request import Attached  # noqa: PLC0415 - seldom needed

        arguments, ranges = (self.plan.arguments, self.plan.ranges) if not self.has_values else ((), ())
        applied = Binding(_APPLIED, self.plan.span)
        constraints: list[Constraint] = []
        for name, value in arguments:
            parameter = Member(applied, name, value.span)
            constraints.append(Constraint(Compare("==", parameter, value, value.span), False, value.span))
        for name, value in ranges:
            parameter = Member(applied, name, value.span)
            constraints.append(Constraint(Contains(parameter, value, value.span), False, value.span))
        around = {**self.around.bindings, _APPLIED: self.inside.instance}
        return Attached(
            structure=self.modifier.structure,
            environment=replace(self.inside, calls=calls),
            given=dict(self.fields),
            constraints=tuple(constraints),
            around=replace(self.around, bindings=around, calls=calls),
        )


Modifying: TypeAlias = Until | Applied | Override
"""What is done to a behavior as a whole, once its modifiers are instances."""


def apply(
    modifications: Iterable[Modification],
    modifiers: Mapping[str, Modifier],
    around: Environment,
    it: HasFields,
    position: tuple[int, ...],
) -> tuple[Modifying, ...]:
    """The modifications of a behavior, without values yet.

    Args:
        modifications: As they are written.
        modifiers: The modifiers, by their names.
        around: The scope in which they are written.
        it: What is modified.
        position: Of all of them, among what modifies one behavior.
    """
    return tuple(
        _apply_one(each, modifiers, around, it, (*position, number))
        if isinstance(each, ModifierApplication)
        else each
        for number, each in enumerate(modifications)
    )


def _apply_one(
    application: ModifierApplication,
    modifiers: Mapping[str, Modifier],
    around: Environment,
    it: HasFields,
    position: tuple[int, ...],
) -> Applied:
    modifier = modifiers[application.modifier]
    bindings: dict[str, Value | HasFields] = {_IT: it}
    if application.actor is not None:
        bindings["actor"] = cast(Value, Deferred(application.actor, around))  # no value, but stands for one
    inside = Environment(
        Instance(modifier.name, Fields(), modifier, bindings, around.outermost),
        bindings,
        modifier.name,
        around.outermost,
        seed=Seed(around.seed, f"{position[-1]} {modifier.name}"),
        run=around.run,
    )
    nested = cast(tuple[Applied | Override, ...], apply(modifier.modifiers, modifiers, inside, it, position))
    return Applied(application, modifier, around, inside, bindings, nested, position)


def with_nested(modifications: Iterable[Modifying]) -> Iterator[Applied]:
    """All modifiers that are applied, each before those that it applies in turn."""
    for modification in modifications:
        if isinstance(modification, Applied):
            yield modification
            yield from with_nested(modification.modifiers)
