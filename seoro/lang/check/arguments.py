"""Binding arguments to parameters: positional ones by their place, then named ones (7.4.2.1)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, TypeAlias

from seoro.lang import ast, plan
from seoro.lang.check.named_files import is_missing
from seoro.lang.check.paths import fields_on, leads_to_variable
from seoro.lang.check.plan_types import plan_type
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import constraints as constraint_messages
from seoro.lang.diagnostics import types as type_messages
from seoro.lang.members import MemberTable
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, Kind
from seoro.lang.traits import ParameterTrait
from seoro.lang.types import CompositionObject, EventObject, RangeOf, Structured, is_known, is_number

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions
    from seoro.lang.check.scopes import Scope

Traits: TypeAlias = Mapping[tuple[Kind, str], Mapping[str, ParameterTrait]]
"""What Python takes for the parameters of actions and modifiers, by their names; of the rest, it takes values."""
NO_TRAITS: Final[Traits] = {}
_VALUES: Final[Mapping[str, ParameterTrait]] = {}


def bind(
    expressions: Expressions,
    owner: str,
    parameters: MemberTable[FieldSymbol],
    arguments: ast.ArgumentList | None,
    scope: Scope,
    is_open: bool = False,
    traits: Mapping[str, ParameterTrait] = _VALUES,
    is_method: bool = False,
    ranges: dict[str, plan.Expression] | None = None,
    types: dict[str, plan.ValueType] | None = None,
) -> dict[str, plan.Expression]:
    """The values of the parameters that are given, in the order in which they are given.

    Args:
        expressions: For the values, and for messages.
        owner: What takes the arguments, for messages.
        parameters: Its parameters, in their order.
        arguments: The arguments; None if there are none.
        scope: Where they stand.
        is_open: Whether there may be parameters that are not known.
        traits: What a Python implementation takes for parameters, where it differs from the declaration.
        is_method: Whether a method takes the arguments.
        ranges: Takes ranges given for parameters that hold one number (7.3.5.1.3); None if they are wrong.
        types: Takes the static types of arguments that may be of any type.
    """
    if arguments is None:
        return {}
    binding = _Binding(expressions, owner, parameters, scope, is_open, traits, is_method, ranges, types)
    binding.bind_positional(arguments.positional)
    for argument in arguments.named:
        binding.bind_named(argument)
    return binding.given


@dataclass(eq=False)
class _Binding:
    """Arguments that are being bound; the fields are those of `bind`."""

    expressions: Expressions
    owner: str
    parameters: MemberTable[FieldSymbol]
    scope: Scope
    is_open: bool
    traits: Mapping[str, ParameterTrait]
    is_method: bool
    ranges: dict[str, plan.Expression] | None
    types: dict[str, plan.ValueType] | None
    given: dict[str, plan.Expression] = field(default_factory=dict)
    places: dict[str, Span] = field(default_factory=dict)

    def bind_positional(self, values: tuple[ast.Expression, ...]) -> None:
        order = list(self.parameters.values())
        for place, value in enumerate(values):
            if place < len(order):
                self._give(order[place], value, value.span)
                continue
            self.expressions.value(value, self.scope)
            if not self.is_open:
                self.expressions.bag.add(messages.TooManyArguments(value.span, self.owner, len(order)))

    def bind_named(self, argument: ast.NamedArgument) -> None:
        name = argument.name
        parameter = self.expressions.lookup.parameter(self.scope.space, self.parameters, name)
        if parameter is None:
            self.expressions.value(argument.value, self.scope)
            self._report_unknown(name)
            return
        if parameter.name in self.places:
            self.expressions.bag.add(messages.ArgumentTwice(name.span, name.text, self.places[parameter.name]))
        self._give(parameter, argument.value, name.span)

    def _report_unknown(self, name: ast.Name) -> None:
        bag = self.expressions.bag
        if not self.is_open and not self.expressions.program.is_unread(name.text):
            known = tuple(parameter.text for parameter in self.parameters.values())
            bag.add(messages.UnknownArgument(name.span, self.owner, name.text, known))

    def _give(self, parameter: FieldSymbol, value: ast.Expression, place: Span) -> None:
        self.places[parameter.name] = place
        trait = self.traits.get(parameter.name, ParameterTrait.VALUE)
        match trait:
            case ParameterTrait.ANY:
                self.given[parameter.name] = self._any_value(parameter, value)
            case ParameterTrait.VARIABLE | ParameterTrait.NUMBER:
                self.given[parameter.name] = self._variable(value, trait is ParameterTrait.NUMBER)
            case ParameterTrait.VALUE:
                self._give_value(parameter, value)
            case ParameterTrait.FILE | ParameterTrait.URI:
                self._give_value(parameter, value)
                self._check_file(parameter, value.span, trait)

    def _give_value(self, parameter: FieldSymbol, value: ast.Expression) -> None:
        """A value of the parameter's type; or a range, for a parameter that holds one number."""
        expressions, type_ = self.expressions, parameter.type
        context = f"`{parameter.text}` of `{self.owner}`"
        found = expressions.value(value, self.scope, type_)
        if self.ranges is not None and isinstance(found.type, RangeOf) and is_number(type_):
            self.ranges[parameter.name] = expressions.converter.convert(found, RangeOf(type_), context)
        else:
            self.given[parameter.name] = expressions.converter.convert(found, type_, context)

    def _check_file(self, parameter: FieldSymbol, span: Span, trait: ParameterTrait) -> None:
        """Warn of a literal that names a file which does not exist on this machine."""
        given = self.given.get(parameter.name)
        if not isinstance(given, plan.Literal) or not isinstance(given.value, str):
            return
        entry = self.expressions.program.nowhere.file
        if is_missing(given.value, trait, (entry.path, span.file.path)):
            is_uri = trait is ParameterTrait.URI
            self.expressions.bag.add(messages.MissingFile(span, given.value, is_uri))

    def _variable(self, value: ast.Expression, is_a_number: bool) -> plan.Expression:
        """The path of a variable, which is passed itself instead of its value."""
        expressions = self.expressions
        found = expressions.value(value, self.scope)
        if not is_known(found.type):
            return found.expression
        fields = fields_on(found.expression, self.scope, expressions.program)
        if not fields or not leads_to_variable(fields) or isinstance(found.expression, plan.Index):
            parameter = fields[-1].span if fields else None
            expressions.bag.add(constraint_messages.NoVariable(value.span, value.span.text, parameter))
        elif is_a_number and not is_number(found.type):
            described = expressions.converter.describe(found.type)
            expressions.bag.add(type_messages.Mismatch(value.span, "a variable that holds a number", described))
        return plan.Reference(found.expression, plan_type(found.type, expressions.program), value.span)

    def _any_value(self, parameter: FieldSymbol, value: ast.Expression) -> plan.Expression:
        """A value of any type but that of what runs."""
        expressions = self.expressions
        found = expressions.value(value, self.scope)
        if isinstance(found.type, Structured) and found.type.symbol.kind not in {Kind.STRUCT, Kind.ACTOR}:
            kind = f"a running {found.type.symbol.kind.value}"
            expressions.bag.add(type_messages.NotAValue(value.span, value.span.text, kind))
        elif isinstance(found.type, CompositionObject | EventObject):
            kind = "an occurrence" if isinstance(found.type, EventObject) else "a running behavior"
            expressions.bag.add(type_messages.NotAValue(value.span, value.span.text, kind))
        if expressions.strict and is_known(found.type) and found.type != parameter.type:
            declared = expressions.converter.describe(parameter.type)
            expressions.bag.add(type_messages.AnyArgument(value.span, parameter.name, declared))
        if self.types is not None and is_known(found.type):
            self.types[parameter.name] = plan_type(found.type, expressions.program)
        return found.expression
