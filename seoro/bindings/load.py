"""Checks a scenario, and binds its declarations to Python."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import ModuleType

from seoro.bindings.externals import bind_externals
from seoro.bindings.implementations import BoundFunctions, bind_implementations, find_implementations, traits_of
from seoro.lang.check.checker import Checked, in_order
from seoro.lang.check.plan_types import plan_type
from seoro.lang.check.recall import BodyMessages
from seoro.lang.diagnostic import Bag
from seoro.lang.frontend import check
from seoro.lang.frozen import Value
from seoro.lang.loader import Sources
from seoro.lang.plan import ValueType
from seoro.lang.recorder import Recorder
from seoro.lang.symbols import Program, TypeSymbol, all_fields
from seoro.runtime.fitting import Fitting


class Bound(Value):
    """A scenario file that has been checked, with its libraries.

    Args:
        checked: The file with all that it imports, and all messages; its external methods have their functions.
        functions: The functions that carry out actions and modifiers.
    """

    checked: Checked
    functions: BoundFunctions


def bind_sources(
    sources: Sources,
    *,
    strict: bool,
    is_own_only: bool,
    given: Iterable[ModuleType],
    recorder: Recorder | None,
    known: BodyMessages | None = None,
) -> Bound:
    """Check what was read, and bind what it declares; what is wrong stands in the diagnostics.

    Args:
        sources: A scenario file with all it imports.
        strict: Report the use of extensions to the standard, too.
        is_own_only: Whether to import no Python modules but seoro's own, and leave the rest unbound.
        given: Modules that a program gives; what they carry out goes before what libraries do.
        recorder: Is told what names mean and of what types values are.
        known: What is known from an earlier check of the same file.
    """
    bag = Bag()
    found = find_implementations(sources, given, is_own_only, bag)
    checked = check(sources, traits_of(found), strict, recorder, known)
    functions = BoundFunctions()
    if not sources.diagnostics:  # else nothing is declared
        fitting = Fitting(_Shapes(checked.program).of)
        functions = bind_implementations(checked, found, fitting, bag)
        bind_externals(checked, fitting, is_own_only, bag)
    diagnostics = in_order(sources, (*checked.diagnostics, *bag.diagnostics))
    return Bound(replace(checked, diagnostics=diagnostics), functions)


class _Shapes:
    """The fields of structs.

    Args:
        program: Which declares them.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        structs = (symbol for symbol in program.types.values() if isinstance(symbol, TypeSymbol))
        self._symbols = {symbol.plan_name: symbol for symbol in structs}

    def of(self, name: str) -> Mapping[str, ValueType]:
        """The types of the fields of a struct, by its name in the plan."""
        fields = all_fields(self._symbols[name]).values()
        return {field.name: plan_type(field.type, self._program) for field in fields}
