"""The Python functions that carry out actions and modifiers, and whether they fit what is declared."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field
from pathlib import Path
from types import ModuleType
from typing import Any

from seoro.bindings.modules import ImportFailed, function_name, library_module
from seoro.lang import ast
from seoro.lang.check.arguments import Traits
from seoro.lang.check.checker import Checked
from seoro.lang.check.plan_types import plan_type
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import bindings as messages
from seoro.lang.diagnostics import listing
from seoro.lang.frozen import Value
from seoro.lang.libraries import Library, Origin
from seoro.lang.loader import Sources
from seoro.lang.symbols import Kind, TypeSymbol, all_fields, do_directive
from seoro.lang.traits import ParameterTrait
from seoro.runtime.actions import ACTION_MARK, BoundAction, Mark, bind
from seoro.runtime.fitting import Fitting
from seoro.runtime.modifiers import MODIFIER_MARK, BoundModifier, ModifierMark, bind_modifier
from seoro.runtime.signatures import Declaration, Misfit, traits


class Implementation(Value):
    """A function that says what it carries out.

    Args:
        mark: What it says.
        function: The function.
        library: The library whose module defines it; None if it comes from elsewhere.
    """

    mark: Mark | ModifierMark
    function: Callable[..., Any]
    library: Library | None

    @property
    def key(self) -> tuple[Kind, str]:
        """What it carries out: an action or a modifier, and its name."""
        return Kind.ACTION if isinstance(self.mark, Mark) else Kind.MODIFIER, self.mark.name


Implementations = Mapping[tuple[Kind, str], Implementation]


# ---------------------------------------------------------------- finding them


def find_implementations(
    sources: Sources, given: Iterable[ModuleType], is_own_only: bool, bag: Bag
) -> Implementations:
    """The functions that carry something out.

    Args:
        sources: The scenario, with its libraries.
        given: Modules that a program gives; what they carry out goes before what libraries do.
        is_own_only: Whether to leave libraries alone that are not seoro's own.
        bag: For messages.
    """
    found = {made.key: made for module in given for made in _marked(module, None)}
    first: dict[tuple[Kind, str], Implementation] = {}
    for library in sources.libraries:
        if is_own_only and library.origin is not Origin.OWN:
            continue
        for made in _of_library(library, sources, bag):
            other = first.setdefault(made.key, made)
            if other.function is not made.function:
                functions = function_name(other.function), function_name(made.function)
                bag.add(messages.SeveralImplementations(library.span, made.key[0].value, made.key[1], functions))
    return {**first, **found}


def _of_library(library: Library, sources: Sources, bag: Bag) -> Iterator[Implementation]:
    try:
        module = library_module(library)
    except ImportFailed as error:
        bag.add(messages.BrokenModule(library.span, library.name, error.module, error.reason, error.hint))
        return
    if module is not None:
        yield from _marked(module, library)
        return
    actions = _declared_actions(library, sources)
    if library.origin is Origin.BESIDE and actions:
        path = Path(library.shown).with_suffix(".py")
        expected = path if path.parent.name != library.module else path.with_name("__init__.py")
        bag.add(messages.NoImplementation(library.span, library.name, listing(actions), str(expected)))


def _declared_actions(library: Library, sources: Sources) -> list[str]:
    """Names of the actions of a library that Python would have to carry out."""
    return [
        statement.name.span.text
        for module in sources.modules
        if module.library == library.name
        for statement in module.tree.statements
        if isinstance(statement, ast.ActionDeclaration)
        and not any(isinstance(member, ast.DoDirective) for member in statement.members)
    ]


def _marked(module: ModuleType, library: Library | None) -> Iterator[Implementation]:
    for value in vars(module).values():
        mark = getattr(value, ACTION_MARK, None) or getattr(value, MODIFIER_MARK, None)
        if isinstance(mark, Mark | ModifierMark):
            is_own = getattr(value, "__module__", None) == module.__name__
            yield Implementation(mark, value, library if is_own else None)


def traits_of(found: Implementations) -> Traits:
    """How arguments for the parameters of actions and modifiers are checked and passed."""
    return {key: {**traits(made.function), **_file_traits(made.mark)} for key, made in found.items()}


def _file_traits(mark: Mark | ModifierMark) -> dict[str, ParameterTrait]:
    """The traits of parameters that name files."""
    if isinstance(mark, ModifierMark):
        return {}
    return {
        **dict.fromkeys(mark.files, ParameterTrait.FILE),
        **dict.fromkeys(mark.uris, ParameterTrait.URI),
    }


# ---------------------------------------------------------------- matching them


class BoundFunctions(Value):
    """The functions that carry out what a scenario and its libraries declare, by qualified names."""

    actions: dict[str, BoundAction] = field(default_factory=dict)
    modifiers: dict[str, BoundModifier] = field(default_factory=dict)


def bind_implementations(checked: Checked, found: Implementations, fitting: Fitting, bag: Bag) -> BoundFunctions:
    """Match functions with what they carry out.

    Args:
        checked: The scenario with its libraries, which declare it.
        found: The functions.
        fitting: For the types.
        bag: For messages.
    """
    symbols = _symbols(checked)
    wrong = {message.primary.span.file for message in checked.errors}  # types may be unknown there
    bound = BoundFunctions()
    for key, made in found.items():
        symbol = symbols.get(key)
        if symbol is None:
            _report_undeclared(made, symbols, bag)
        elif isinstance(made.mark, Mark) and inspect.iscoroutinefunction(made.function) == made.mark.thread:
            message = messages.AsyncInThread if made.mark.thread else messages.PlainFunction
            bag.add(message(symbol.span, function_name(made.function), made.mark.name))
        elif symbol.span.file not in wrong:
            try:
                _match(symbol, made, checked, fitting, bound)
            except Misfit as misfit:
                name, kind = function_name(made.function), key[0].value
                bag.add(messages.OtherParameters(symbol.span, name, kind, key[1], str(misfit), misfit.expected))
    return bound


def _symbols(checked: Checked) -> dict[tuple[Kind, str], TypeSymbol]:
    """The declarations of actions and modifiers."""
    program = checked.program
    declared = (*program.behaviors.values(), *program.modifiers.values())
    return {(symbol.kind, symbol.plan_name): symbol for symbol in declared}


def _report_undeclared(made: Implementation, symbols: Mapping[tuple[Kind, str], TypeSymbol], bag: Bag) -> None:
    if made.library is None:
        return  # its module may have more than this scenario needs
    kind, name = made.key
    declared = tuple(
        other for (is_kind, other), symbol in symbols.items()
        if is_kind is kind and symbol.home.library == made.library.name
    )  # fmt: skip
    function = function_name(made.function)
    bag.add(messages.Undeclared(made.library.span, made.library.name, function, kind.value, name, declared))


def _match(
    symbol: TypeSymbol, made: Implementation, checked: Checked, fitting: Fitting, bound: BoundFunctions
) -> None:
    if do_directive(symbol) is not None:
        raise Misfit("the declaration has a `do`, which carries it out")
    fields = all_fields(symbol).values()
    parameters = {field.name: plan_type(field.type, checked.program) for field in fields}
    declaration = Declaration(symbol.actor is not None, parameters)
    if isinstance(made.mark, Mark):
        bound.actions[made.mark.name] = bind(declaration, made.mark, made.function, fitting)
    else:
        bound.modifiers[made.mark.name] = bind_modifier(declaration, made.function, fitting)
