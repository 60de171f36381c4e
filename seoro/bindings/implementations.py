"""Lookup of Python functions that implement actions and modifiers, and their match with declarations."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from seoro.bindings.bound_functions import BoundFunctions
from seoro.bindings.imports import ImportFailed, function_name, library_module
from seoro.bindings.ros_texts import VETS
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
from seoro.lang.plan import ValueType
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.symbols import Kind, TypeSymbol
from seoro.lang.traits import ParameterTrait, Trait, Vetted
from seoro.lang.tree import find
from seoro.runtime.functions.actions import ACTION_MARK, Mark, bind
from seoro.runtime.functions.fitting import Fitting
from seoro.runtime.functions.modifiers import MODIFIER_MARK, ModifierMark, bind_modifier
from seoro.runtime.functions.signatures import Declaration, SignatureMismatch, traits

_KINDS: Final = {ast.ActionDeclaration: Kind.ACTION, ast.ModifierDeclaration: Kind.MODIFIER}


class Implementation(Value):
    """Function with the decorator of an action or a modifier.

    Args:
        mark: Data of the decorator.
        function: The function.
        library: Library whose module defines it, if any.
    """

    mark: Mark | ModifierMark
    function: Callable[..., Any]
    library: Library | None

    @property
    def key(self) -> tuple[Kind, str]:
        """Kind (action or modifier) and name of the implemented declaration."""
        return Kind.ACTION if isinstance(self.mark, Mark) else Kind.MODIFIER, self.mark.name


Implementations = Mapping[tuple[Kind, str], Implementation]


# ---------------------------------------------------------------- lookup


def find_implementations(
    sources: Sources, given: Iterable[ModuleType], is_own_only: bool, bag: Bag
) -> Implementations:
    """Find the implementations of actions and modifiers.

    Args:
        sources: Scenario with its libraries.
        given: Modules of the calling program; they take precedence over libraries.
        is_own_only: Whether to import only seoro's own libraries.
        bag: Bag for diagnostics.
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
                bag.add(messages.several_implementations, library.span, made.key[0].value, made.key[1], functions)
    return {**first, **found}


def _of_library(library: Library, sources: Sources, bag: Bag) -> Iterator[Implementation]:
    try:
        module = library_module(library)
    except ImportFailed as error:
        bag.add(messages.broken_module, library.span, library.name, error.module, error.reason, error.hint)
        return
    if module is not None:
        yield from _marked(module, library)
        return
    actions = _declared_actions(library, sources)
    if library.origin is Origin.BESIDE and actions:
        path = Path(library.shown).with_suffix(".py")
        expected = path if path.parent.name != library.module else path.with_name("__init__.py")
        bag.add(messages.no_implementation, library.span, library.name, listing(actions), str(expected))


def _declared_actions(library: Library, sources: Sources) -> list[str]:
    """Return the names of the actions of a library that need an implementation in Python."""
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
    """Return the traits of parameters, which control checks and passing of arguments."""
    all_traits: dict[tuple[Kind, str], dict[str, Trait]] = {
        key: dict(traits(made.function)) for key, made in found.items()
    }
    for key, made in found.items():
        if isinstance(made.mark, Mark):
            all_traits[key] |= dict.fromkeys(made.mark.files, ParameterTrait.FILE)
            all_traits[key] |= dict.fromkeys(made.mark.uris, ParameterTrait.URI)
            all_traits[key] |= {name: Vetted(VETS[kind]) for name, kind in made.mark.ros.items()}
    return all_traits


def unread_traits(sources: Sources) -> Traits:
    """Return traits of parameters of type `string` whose Python is not imported.

    Their functions may take variables or values of any type, which are declared as strings.
    """
    skipped = {library.name for library in sources.libraries if library.origin is not Origin.OWN}
    return {
        (_KINDS[type(statement)], statement.name.span.text): {
            name.text: ParameterTrait.ANY
            for member in statement.members
            if isinstance(member, ast.ParameterDeclaration) and member.type.span.text == "string"
            for name in member.names
        }
        for module in sources.modules
        if module.library in skipped
        for statement in module.tree.statements
        if isinstance(statement, ast.ActionDeclaration | ast.ModifierDeclaration)
    }


# ---------------------------------------------------------------- match


def bind_implementations(checked: Checked, found: Implementations, fitting: Fitting, bag: Bag) -> BoundFunctions:
    """Match functions with declarations.

    Args:
        checked: Scenario with its libraries.
        found: The functions.
        fitting: Conversion of types.
        bag: Bag for diagnostics.
    """
    program = checked.program
    declared = (*program.behaviors.values(), *program.modifiers.values())
    symbols = {(symbol.kind, symbol.plan_name): symbol for symbol in declared}
    wrong = {message.primary.span.file for message in checked.errors}  # types may be unknown there
    bound = BoundFunctions()
    for key, made in found.items():
        symbol = symbols.get(key)
        if symbol is None:
            _report_undeclared(made, symbols, bag)
        elif isinstance(made.mark, Mark) and inspect.iscoroutinefunction(made.function) == made.mark.thread:
            message = messages.async_in_thread if made.mark.thread else messages.plain_function
            bag.add(message, symbol.span, function_name(made.function), made.mark.name)
        elif symbol.span.file not in wrong:
            try:
                _match(symbol, made, checked, fitting, bound)
            except SignatureMismatch as mismatch:
                name, kind = function_name(made.function), key[0].value
                reason, expected = str(mismatch), mismatch.expected
                bag.add(messages.implementation_mismatch, symbol.span, name, kind, key[1], reason, expected)
    return bound


def _report_undeclared(made: Implementation, symbols: Mapping[tuple[Kind, str], TypeSymbol], bag: Bag) -> None:
    if made.library is None:
        return  # the module may serve other scenarios, too
    kind, name = made.key
    declared = tuple(
        other for (is_kind, other), symbol in symbols.items()
        if is_kind is kind and symbol.home.library == made.library.name
    )  # fmt: skip
    function = function_name(made.function)
    bag.add(messages.undeclared, made.library.span, made.library.name, function, kind.value, name, declared)


def field_types(symbol: TypeSymbol, program: Program) -> dict[str, ValueType]:
    """Return the types of the fields of a declaration, by name."""
    return {field.name: plan_type(field.type, program) for field in symbol.inventory.fields.values()}


def _match(
    symbol: TypeSymbol, made: Implementation, checked: Checked, fitting: Fitting, bound: BoundFunctions
) -> None:
    if symbol.do is not None:
        raise SignatureMismatch("the declaration has a `do`, and so needs no function")
    declaration = Declaration(symbol.actor is not None, field_types(symbol, checked.program))
    if isinstance(made.mark, Mark):
        bound.actions[made.mark.name] = bind(declaration, made.mark, made.function, fitting)
    else:
        bound.modifiers[made.mark.name] = bind_modifier(declaration, made.function, fitting)


# ---------------------------------------------------------------- actions without a function

DECLARING_LIBRARIES: Final = frozenset({"osc.docker", "osc.kubernetes", "osc.pybullet", "osc.x11"})
"""Libraries of seoro that declare actions, which only installed packages implement."""


def unimplemented(checked: Checked, bound: BoundFunctions) -> list[tuple[TypeSymbol, Span]]:
    """Return the invoked actions without a `do` and without a function that installed packages may implement.

    Each has its first invocation.

    Args:
        checked: Scenario with its libraries.
        bound: Functions of the scenario.
    """
    sources = checked.sources
    foreign = {library.name for library in sources.libraries if library.origin is not Origin.OWN}
    wrong = {message.primary.span.file for message in checked.errors}  # types may be unknown there
    missing = [
        symbol
        for symbol in checked.program.behaviors.values()
        if symbol.kind is Kind.ACTION
        and symbol.do is None
        and symbol.plan_name not in bound.actions
        and (symbol.home.library in (None, *DECLARING_LIBRARIES) or symbol.home.library in foreign)
        and symbol.span.file not in wrong
    ]
    if not missing:
        return []
    trees = [module.tree for module in sources.modules if module.library is None or module.library in foreign]
    invoked = dict(invocation for tree in reversed(trees) for invocation in reversed(list(_invoked(tree))))
    named = ((symbol, invoked.get(symbol.plan_name.rpartition(".")[2])) for symbol in missing)
    return [(symbol, span) for symbol, span in named if span is not None]


def _invoked(tree: ast.OscFile) -> Iterator[tuple[str, Span]]:
    """Yield the names of the behaviors that a file invokes, without actors, and the invocations."""
    for node in find(tree, ast.BehaviorInvocation):
        name = node.invocation.span.text.partition("(")[0].replace("::", ".").rpartition(".")[2].strip()
        yield name, node.invocation.span
