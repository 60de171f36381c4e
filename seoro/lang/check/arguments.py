"""Binding of arguments to parameters: positional ones by order, then named ones (7.4.2.1)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field
from pathlib import Path
from typing import Final, TypeAlias
from urllib.parse import unquote

from seoro.deferred import dataclass
from seoro.lang import ast, plan
from seoro.lang.check.constraints import fields_on, leads_to_variable
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostics import behaviors
from seoro.lang.diagnostics import types as type_messages
from seoro.lang.members import MemberTable
from seoro.lang.source import Span
from seoro.lang.symbols import CompositionObject, EventObject, FieldSymbol, Kind, RangeOf, Structured
from seoro.lang.traits import ParameterTrait, Trait, Vet, Vetted
from seoro.lang.types import is_known, is_number

Traits: TypeAlias = Mapping[tuple[Kind, str], Mapping[str, Trait]]
"""Traits of the parameters of actions and modifiers in Python, by name; all others get plain values."""
NO_TRAITS: Final[Traits] = {}
_SCHEME: Final = "://"
_FILE_SCHEME: Final = "file://"
_SUFFIXES: Final = frozenset({".sdf", ".urdf", ".world", ".xml", ".yaml", ".yml"})  # of models and worlds


@dataclass(eq=False)
class Binding:
    """Binds the arguments of one call to parameters.

    Args:
        expressions: The expression checker.
        owner: Name of the callee, for messages.
        parameters: Its parameters, in order.
        scope: Scope of the arguments.
        is_open: Whether the callee may have unknown parameters.
        traits: Traits of parameters in a Python implementation, where they differ from the declaration.
        may_be_ranges: Whether arguments for parameters that hold one number may be ranges (7.3.5.1.3).
        ranges: These ranges.
        types: The static types of arguments that may be of any type.
        given: The values of the given parameters, in the order of the arguments.
        places: The places of these arguments.
    """

    expressions: ExpressionChecker
    owner: str
    parameters: MemberTable[FieldSymbol]
    scope: Scope
    is_open: bool = False
    traits: Mapping[str, Trait] = field(default_factory=dict)
    may_be_ranges: bool = False
    ranges: dict[str, plan.Expression] = field(default_factory=dict)
    types: dict[str, plan.ValueType] = field(default_factory=dict)
    given: dict[str, plan.Expression] = field(default_factory=dict)
    places: dict[str, Span] = field(default_factory=dict)

    def bind(self, arguments: ast.ArgumentList | None) -> dict[str, plan.Expression]:
        """Bind the arguments, and return the values of the given parameters, in the order of the arguments."""
        if arguments is not None:
            self._bind_positional(arguments.positional)
            for argument in arguments.named:
                self._bind_named(argument)
        return self.given

    def _bind_positional(self, values: tuple[ast.Expression, ...]) -> None:
        order = list(self.parameters.values())
        for place, value in enumerate(values):
            if place < len(order):
                self._give(order[place], value, value.span)
                continue
            self.expressions.value(value, self.scope)
            if not self.is_open:
                self.expressions.bag.add(behaviors.too_many_arguments, value.span, self.owner, len(order))

    def _bind_named(self, argument: ast.NamedArgument) -> None:
        name = argument.name
        parameter = self.expressions.lookup.parameter(self.scope.space, self.parameters, name)
        if parameter is None:
            self.expressions.value(argument.value, self.scope)
            self._report_unknown(name)
            return
        if parameter.name in self.places:
            self.expressions.bag.add(
                behaviors.duplicate_argument, name.span, name.text, self.places[parameter.name]
            )
        self._give(parameter, argument.value, name.span)

    def _report_unknown(self, name: ast.Name) -> None:
        bag = self.expressions.bag
        if not self.is_open and not self.expressions.program.is_unread(name.text):
            known = tuple(parameter.text for parameter in self.parameters.values())
            bag.add(behaviors.unknown_argument, name.span, self.owner, name.text, known)

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
            case Vetted(vet):
                self._give_value(parameter, value)
                self._vet(parameter, value.span, vet)

    def _give_value(self, parameter: FieldSymbol, value: ast.Expression) -> None:
        """Bind a value of the parameter's type, or a range for a parameter that holds one number."""
        expressions, type_ = self.expressions, parameter.type
        context = f"`{parameter.text}` of `{self.owner}`"
        found = expressions.value(value, self.scope, type_)
        if self.may_be_ranges and isinstance(found.type, RangeOf) and is_number(type_):
            self.ranges[parameter.name] = expressions.converter.convert(found, RangeOf(type_), context)
        else:
            self.given[parameter.name] = expressions.converter.convert(found, type_, context)

    def _check_file(self, parameter: FieldSymbol, span: Span, trait: ParameterTrait) -> None:
        """Warn if a literal names a file that does not exist on this machine."""
        text = self._literal(parameter)
        if text is None:
            return
        entry = self.expressions.program.nowhere.file
        if _is_missing(text, trait, (entry.path, span.file.path)):
            is_uri = trait is ParameterTrait.URI
            self.expressions.bag.add(behaviors.missing_file, span, text, is_uri)

    def _vet(self, parameter: FieldSymbol, span: Span, vet: Vet) -> None:
        """Warn of an unsuitable literal."""
        text = self._literal(parameter)
        if text is not None and (problem := vet(text)) is not None:
            self.expressions.bag.add(behaviors.unsuitable_text, span, *problem)

    def _literal(self, parameter: FieldSymbol) -> str | None:
        """Return the text of an argument that is a literal."""
        given = self.given.get(parameter.name)
        return given.value if isinstance(given, plan.Literal) and isinstance(given.value, str) else None

    def _variable(self, value: ast.Expression, is_a_number: bool) -> plan.Expression:
        """Return the path of a variable, which is passed by reference."""
        expressions = self.expressions
        found = expressions.value(value, self.scope)
        if not is_known(found.type):
            return found.expression
        fields = fields_on(found.expression, self.scope, expressions.program)
        if not fields or not leads_to_variable(fields) or isinstance(found.expression, plan.Index):
            parameter = fields[-1].span if fields else None
            expressions.bag.add(behaviors.not_a_variable, value.span, value.span.text, parameter)
        elif is_a_number and not is_number(found.type):
            described = expressions.converter.describe(found.type)
            expressions.bag.add(type_messages.mismatch, value.span, "a variable that holds a number", described)
        return plan.Reference(found.expression, plan_type(found.type, expressions.program), value.span)

    def _any_value(self, parameter: FieldSymbol, value: ast.Expression) -> plan.Expression:
        """Return a value of any type except running behaviors."""
        expressions = self.expressions
        found = expressions.value(value, self.scope)
        if isinstance(found.type, Structured) and found.type.symbol.kind not in {Kind.STRUCT, Kind.ACTOR}:
            kind = f"a running {found.type.symbol.kind.value}"
            expressions.bag.add(type_messages.not_a_value, value.span, value.span.text, kind)
        elif isinstance(found.type, CompositionObject | EventObject):
            kind = "an occurrence" if isinstance(found.type, EventObject) else "a running behavior"
            expressions.bag.add(type_messages.not_a_value, value.span, value.span.text, kind)
        if expressions.strict and is_known(found.type) and found.type != parameter.type:
            declared = expressions.converter.describe(parameter.type)
            expressions.bag.add(type_messages.any_argument, value.span, parameter.name, declared)
        if is_known(found.type):
            self.types[parameter.name] = plan_type(found.type, expressions.program)
        return found.expression


def _is_missing(text: str, trait: ParameterTrait, files: Iterable[Path | None]) -> bool:
    """Return whether a text names a missing file or folder.

    Names that simulators resolve, such as `garden://pot.sdf` or `maze`, do not count.

    Args:
        text: The literal.
        trait: Trait of the parameter: `FILE` or `URI`.
        files: Scenario files whose folders are searched, besides the working directory.
    """
    if trait is ParameterTrait.URI:
        if text.startswith(_FILE_SCHEME):
            text = unquote(text.removeprefix(_FILE_SCHEME))
        elif _SCHEME in text or Path(text).suffix not in _SUFFIXES:
            return False
    folders = [Path(), *(file.parent for file in files if file is not None)]
    return bool(text) and not any(_exists(folder / text) for folder in folders)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # too long, not permitted, or with a zero in it
        return False
