"""Overrides of parameters of the entry scenario (`goal`, `goal.position.x`) and of its invocations (`drive.goal`).

Values are expressions. They become the last constraints, which replace defaults.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from seoro.lang import plan
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import near
from seoro.lang.parser import parse_expression
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import FieldSymbol, Structured, Type, TypeSymbol
from seoro.lang.types import STRING

ORIGIN = "<override>"


class Given(NamedTuple):
    """Constraints of overrides: on the scenario, and on its invocations by name."""

    own: tuple[plan.Constraint, ...]
    of_invocations: Mapping[str, Sequence[plan.Constraint]]


class Overrides:
    """Applies overrides to the parameters of a scenario.

    Args:
        expressions: Checker of the values.
        scope: The scope of the scenario.
        bag: Bag for messages.
        invoked: Invoked scenarios and actions, by the names of the invocations.
    """

    def __init__(
        self, expressions: Expressions, scope: Scope, bag: Bag, invoked: Mapping[str, TypeSymbol]
    ) -> None:
        self._expressions = expressions
        self._scope = scope
        self._bag = bag
        self._invoked = invoked

    def constraints(self, overrides: Mapping[str, str]) -> Given:
        """Convert overrides to constraints; whole values first, then their parts."""
        own: list[plan.Constraint] = []
        of_invocations: dict[str, list[plan.Constraint]] = {}
        for path, text in sorted(overrides.items(), key=lambda item: item[0].count(".")):
            at = Span(SourceFile(ORIGIN, f"{path}={text}"), 0, len(path))
            first, *rest = path.split(".")
            root = self._root(first, at)
            if root is not None:
                field, left = root
                found = self._constraint(at, left, field.type, rest)
                own += [found] if found is not None else []
            elif first in self._invoked:
                found = self._of_invocation(at, self._invoked[first], rest)
                of_invocations.setdefault(first, []).extend([found] if found is not None else [])
            else:
                self._unknown(at, first, self._scope.fields, self._invoked)
        return Given(tuple(own), of_invocations)

    def _of_invocation(self, at: Span, invoked: TypeSymbol, names: Sequence[str]) -> plan.Constraint | None:
        fields = invoked.inventory.fields
        if not names:
            hint = f"override one of its parameters, as in `{at.text}.{_any(fields)}`"
            self._refuse(at, "it is an invocation", hint)
            return None
        return self._constraint(at, plan.Binding("it", at), Structured(invoked), names)

    def _constraint(
        self, at: Span, left: plan.Expression, type_: Type, rest: Sequence[str]
    ) -> plan.Constraint | None:
        """Create the constraint on a field of a value; report an invalid one and return None.

        Args:
            at: The path, in the text of the override.
            left: The value.
            type_: Its type.
            rest: Names of fields, from the value to the field.
        """
        for name in rest:
            field = self._field(type_, name, at)
            if field is None:
                return None
            type_, left = field.type, plan.Member(left, field.name, at)
        word = at.file.text[at.end + 1 :].strip()
        if type_ is STRING and word.isidentifier() and self._root(word, at) is None:  # quotes lost in a shell
            self._refuse(at, f"unknown name `{word}`", _quoted(at.text, word))
            return None
        node = parse_expression(at.file, self._bag, at.end + 1)
        if node is None:
            return None
        value = self._expressions.converted(node, type_, self._scope, f"`{at.text}`")
        whole = Span(at.file, 0, len(at.file.text))
        return plan.Constraint(plan.Compare("==", left, value, whole), False, whole)

    def _root(self, name: str, at: Span) -> tuple[FieldSymbol, plan.Field | plan.Global] | None:
        """Find the field or the global parameter at the start of a path."""
        for field in self._scope.fields.values():
            if name in {field.name, field.text}:
                return field, plan.Field(field.name, at)
        for parameter in self._expressions.program.globals.values():
            if name in {parameter.name, parameter.text}:
                return parameter, plan.Global(parameter.name, at)
        return None

    def _field(self, type_: Type, name: str, at: Span) -> FieldSymbol | None:
        """Find a field of a value; report an unknown one and return None."""
        if not isinstance(type_, Structured):
            self._refuse(at, f"{self._expressions.converter.describe(type_)} has no field `{name}`")
            return None
        fields = type_.symbol.inventory.fields
        if name not in fields:
            self._unknown(at, name, fields)
            return None
        return fields[name]

    def _unknown(self, at: Span, name: str, fields: Collection[str], invoked: Collection[str] = ()) -> None:
        known = ", ".join(f"`{field}`" for field in fields)
        hint = f"its parameters are {known}" if known else "it has no parameters"
        if invoked:
            hint += f"; those of an invocation are written as in `{_any(invoked)}.PARAMETER`"
        self._refuse(at, f"unknown parameter `{name}`", near(name, [*fields, *invoked]) or hint)

    def _refuse(self, at: Span, reason: str, hint: str = "") -> None:
        self._bag.add(messages.invalid_override, at, at.text, reason, hint)


def _any(names: Collection[str]) -> str:
    return next(iter(names), "...")


def _quoted(path: str, word: str) -> str:
    """Show how to write a string, whose own quotes a shell and Python would remove."""
    return (
        f"""quote a string within the expression: `--set '{path}="{word}"'`, in Python {{'{path}': '"{word}"'}}"""
    )
