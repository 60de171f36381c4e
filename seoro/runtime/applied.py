"""Modifiers as they are applied (7.3.12.4): instances of their own, beside what they modify.

Their parameters get their values together with those of what is invoked, since a modifier may constrain it. An
argument is a constraint on its parameter: that it is equal to a value, or in a range. What is carried out again
gets new values; those of its modifiers stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias, cast

from seoro.lang import frozen
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
    Plan,
    Structures,
    Until,
    modifier_type,
)
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import fill, is_plain
from seoro.runtime.environment import Calls, Deferred, Environment, Seed
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instantiate import Parameters
from seoro.runtime.values import Actor, HasFields, Value

if TYPE_CHECKING:
    from seoro.runtime.choose.choose import Attached

_APPLIED = "applied()"  # what a modifier is bound to around its arguments; no name of the language
_IT = "it"


class Applied(frozen.Frozen):
    """A modifier that is applied.

    Args:
        plan: The application.
        modifier: The modifier.
        around: The scope of its arguments.
        inside: Its own scope.
        bindings: What names are bound to in it; for a composition, there is no `it`.
        modifiers: The modifiers that it applies in turn, the outermost first.
    """

    plan: ModifierApplication
    modifier: Modifier
    around: Environment
    inside: Environment
    bindings: dict[str, Value | HasFields]
    modifiers: tuple[Applied | Override, ...]

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

    def attached(self, calls: Calls) -> Attached:
        """What is to be chosen for it, or because of it.

        Args:
            calls: What external methods have returned.
        """
        from seoro.runtime.choose.choose import Attached  # noqa: PLC0415 - seldom needed

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
    modifications: Iterable[Modification], plan: Plan, around: Environment, it: HasFields | None
) -> tuple[Modifying, ...]:
    """The modifications of a behavior, without values yet.

    Args:
        modifications: As they are written.
        plan: Has the modifiers.
        around: The scope in which they are written.
        it: What is modified; None for a composition.
    """
    return tuple(
        _apply_one(each, plan, around, it, number) if isinstance(each, ModifierApplication) else each
        for number, each in enumerate(modifications)
    )


def _apply_one(
    application: ModifierApplication, plan: Plan, around: Environment, it: HasFields | None, number: int
) -> Applied:
    modifier = plan.modifiers[application.modifier]
    bindings: dict[str, Value | HasFields] = {}
    if it is not None:
        bindings[_IT] = it
    if application.actor is not None:
        bindings["actor"] = cast(Value, Deferred(application.actor, around))  # no value, but stands for one
    inside = Environment(
        Parameters((modifier_type(modifier.name),)),
        bindings,
        modifier.name,
        around.outermost,
        seed=Seed(around.seed, f"{number} {modifier.name}"),
        run=around.run,
    )
    modifiers = cast(tuple[Applied | Override, ...], apply(modifier.modifiers, plan, inside, it))
    return Applied(application, modifier, around, inside, bindings, modifiers)


def with_nested(modifications: Iterable[Modifying]) -> Iterator[Applied]:
    """All modifiers that are applied, each before those that it applies in turn."""
    for modification in modifications:
        if isinstance(modification, Applied):
            yield modification
            yield from with_nested(modification.modifiers)
