"""Values from outside for parameters of the entry scenario: `goal` or `goal.position.x`, as expressions
(section 6 of the semantics: they are placed last and replace defaults)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from seoro.lang import plan
from seoro.lang.check.expressions import Expressions, Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import near
from seoro.lang.parser import parse_expression
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import FieldSymbol, all_fields
from seoro.lang.types import Structured, Type

ORIGIN = "<override>"


class Overrides:
    """Applies overrides to the parameters of a scenario.

    Args:
        expressions: For their values.
        scope: The scope of the scenario.
        bag: Where messages go.
    """

    def __init__(self, expressions: Expressions, scope: Scope, bag: Bag) -> None:
        self._expressions = expressions
        self._scope = scope
        self._bag = bag

    def apply(
        self, values: Mapping[str, plan.Expression], overrides: Mapping[str, str]
    ) -> dict[str, plan.Expression]:
        """The values of the parameters, with those from outside; whole values first, then parts of them."""
        result = dict(values)
        for path, text in sorted(overrides.items(), key=lambda item: item[0].count(".")):
            file = SourceFile(ORIGIN, f"{path}={text}")
            self._apply(result, path, file)
        return result

    def _apply(self, values: dict[str, plan.Expression], path: str, file: SourceFile) -> None:
        first, *rest = path.split(".")
        fields: Mapping[str, FieldSymbol] = self._scope.fields
        if first not in fields:
            self._unknown(path, first, fields, file)
            return
        type_ = self._type(fields[first].type, rest, path, file)
        if type_ is None:
            return
        node = parse_expression(file, self._bag, len(path) + 1)
        if node is None:
            return
        value = self._expressions.converted(node, type_, self._scope, f"`{path}`")
        if not rest:
            values[first] = value
            return
        whole = values.get(first)
        part = self._put(whole, rest, value)
        if part is None:
            self._refuse(
                path, file, f"the value of `{first}` is not constructed there", f"override `{first}` itself"
            )
        else:
            values[first] = part

    def _type(self, type_: Type, rest: list[str], path: str, file: SourceFile) -> Type | None:
        """The type at the end of a path; None if the path leads nowhere, which is reported."""
        for name in rest:
            if not isinstance(type_, Structured):
                self._refuse(path, file, f"{self._expressions.converter.describe(type_)} has no field `{name}`")
                return None
            fields = all_fields(type_.symbol)
            if name not in fields:
                self._unknown(path, name, fields, file)
                return None
            type_ = fields[name].type
        return type_

    def _put(
        self, whole: plan.Expression | None, rest: list[str], value: plan.Expression
    ) -> plan.Expression | None:
        """The constructed value with another value at a path; None if something on the way is not constructed."""
        if not isinstance(whole, plan.Construct):
            return None
        name, *deeper = rest
        given = dict(whole.arguments)
        defaults = dict(whole.defaults)
        if deeper:
            part = self._put(given.get(name, defaults.get(name)), deeper, value)
            if part is None:
                return None
            value = part
        given[name] = value
        defaults.pop(name, None)
        in_order = tuple((field, given[field]) for field in whole.type.fields if field in given)
        return replace(whole, arguments=in_order, defaults=tuple(defaults.items()))

    def _unknown(self, path: str, name: str, fields: Mapping[str, FieldSymbol], file: SourceFile) -> None:
        known = ", ".join(f"`{field}`" for field in fields)
        hint = near(name, fields) or (f"there are {known}" if known else "there are no parameters")
        self._refuse(path, file, f"there is no `{name}`", hint)

    def _refuse(self, path: str, file: SourceFile, reason: str, hint: str = "") -> None:
        self._bag.add(messages.WrongOverride(Span(file, 0, len(path)), path, reason, hint))
