"""Checking a scenario, and binding its declarations to Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import ModuleType

from seoro.bindings.bound_functions import BoundFunctions
from seoro.bindings.externals import bind_externals
from seoro.bindings.implementations import (
    bind_implementations,
    field_types,
    find_implementations,
    traits_of,
    unimplemented,
    unread_traits,
)
from seoro.lang.check.body_cache import BodyMessages
from seoro.lang.check.checker import Checked, in_order
from seoro.lang.diagnostic import Bag
from seoro.lang.frontend import check
from seoro.lang.frozen import replaced
from seoro.lang.loader import Sources
from seoro.lang.plan import ValueType
from seoro.lang.program import Program, Recorder
from seoro.lang.symbols import TypeSymbol
from seoro.runtime.functions.fitting import Fitting


def bind_sources(
    sources: Sources,
    *,
    strict: bool,
    is_own_only: bool,
    given: Iterable[ModuleType],
    recorder: Recorder | None,
    known: BodyMessages | None = None,
) -> tuple[Checked, BoundFunctions]:
    """Check sources and bind their declarations; errors become diagnostics.

    Args:
        sources: Scenario file with all imports.
        strict: Whether to report extensions to the standard, too.
        is_own_only: Whether to import only seoro's own Python modules, and leave the rest unbound.
        given: Modules of the calling program; they take precedence over libraries.
        recorder: Recorder of the meanings of names and the types of values.
        known: Messages from an earlier check of the same file.

    Returns:
        The checked file with its bound external methods, and the functions of its actions and modifiers.
    """
    bag = Bag()
    found = find_implementations(sources, given, is_own_only, bag)
    unread = unread_traits(sources) if is_own_only else {}
    checked = check(sources, {**unread, **traits_of(found)}, strict, recorder, known)
    functions = BoundFunctions()
    if not sources.diagnostics:  # otherwise declarations are missing
        fitting = Fitting(_shapes(checked.program))
        functions = bind_implementations(checked, found, fitting, bag)
        if not is_own_only:
            _bind_plugins(checked, functions, bag)
        bind_externals(checked, fitting, is_own_only, bag)
    diagnostics = in_order(sources, (*checked.diagnostics, *bag.diagnostics))
    return replaced(checked, diagnostics=diagnostics), functions


def _bind_plugins(checked: Checked, functions: BoundFunctions, bag: Bag) -> None:
    missing = unimplemented(checked, functions)
    if missing:
        from seoro.bindings.plugins.find import bind_plugins  # noqa: PLC0415 - few scenarios need them

        bind_plugins(missing, checked.program, functions, bag)


def _shapes(program: Program) -> Callable[[str], Mapping[str, ValueType]]:
    """Make a function that returns the types of the fields of a struct, by its name in the plan."""
    structs = {symbol.plan_name: symbol for symbol in program.types.values() if isinstance(symbol, TypeSymbol)}
    return lambda name: field_types(structs[name], program)
