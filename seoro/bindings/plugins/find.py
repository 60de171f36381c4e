"""Lookup of the classes of actions by their entry points, and their match with declarations."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final

from seoro.bindings.bound_functions import BoundFunctions
from seoro.bindings.implementations import DECLARING_LIBRARIES
from seoro.bindings.imports import function_name, reason_of
from seoro.bindings.plugins.adapter import ACTOR, ActionClass, adapt
from seoro.lang.check.plan_types import plan_type
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import bindings as messages
from seoro.lang.frozen import replaced
from seoro.lang.plan import ValueType
from seoro.lang.program import Program
from seoro.lang.source import Span
from seoro.lang.symbols import Kind, ListOf, TypeSymbol
from seoro.runtime.actions.substitutes import substitute
from seoro.runtime.functions.actions import BoundAction, Mark
from seoro.runtime.functions.signatures import Declaration, SignatureMismatch

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP: Final = "scenario_execution.actions"
_OF_BASE: Final = frozenset({"self", "resolve_variable_reference_arguments_in_execute"})


def bind_plugins(
    missing: Iterable[tuple[TypeSymbol, Span]], program: Program, bound: BoundFunctions, bag: Bag
) -> None:
    """Bind actions to classes of installed packages.

    Args:
        missing: Actions without a function, each with an invocation.
        program: The scenario with its libraries.
        bound: Functions of the scenario; the classes are added.
        bag: Bag for diagnostics.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    points = entry_points(group=GROUP)
    for symbol, span in missing:
        named = list({point.value: point for point in points if point.name == symbol.plan_name}.values())
        point = _choose(named, symbol, bag)
        library = symbol.home.library or ""
        if not named and library in DECLARING_LIBRARIES:
            bag.add(messages.only_declared, span, symbol.plan_name, library, substitute(symbol.plan_name, library))
        if point is not None:
            _bind(point, symbol, program, bound, bag)


def _choose(points: Sequence[EntryPoint], symbol: TypeSymbol, bag: Bag) -> EntryPoint | None:
    """Choose the entry point of an action; of several, that of the package which declares the action."""
    if len(points) < 2:
        return points[0] if points else None
    from seoro.lang.plugin_libraries import library_distributions  # noqa: PLC0415 - seldom needed

    owners = library_distributions((symbol.home.library or "").removeprefix("osc."))
    own = [point for point in points if point.dist is not None and point.dist.name in owners]
    if len(own) == 1:
        return own[0]
    values = points[0].value, points[1].value
    bag.add(messages.several_implementations, symbol.span, Kind.ACTION.value, symbol.plan_name, values)
    return None


def _bind(point: EntryPoint, symbol: TypeSymbol, program: Program, bound: BoundFunctions, bag: Bag) -> None:
    library = symbol.home.library or symbol.plan_name
    try:
        found = point.load()
    except (Exception, SystemExit) as error:
        bag.add(messages.broken_module, symbol.span, library, point.value, reason_of(error), _hint(error))
        return
    fields = symbol.inventory.fields.values()
    parameters = {field.name: plan_type(field.type, program) for field in fields}
    actor = symbol.actor
    variables = {
        field.name: plan_type(field.type, program)
        for field in (actor.inventory.fields.values() if actor is not None else ())
        if field.is_variable
    }
    optional = frozenset(
        field.name
        for field in fields
        if symbol.home.library in DECLARING_LIBRARIES
        and (field.default.span.text == "''" if field.default is not None else isinstance(field.type, ListOf))
    )
    try:
        made = _matched(found, symbol.plan_name, parameters, has_actor=actor is not None)
    except SignatureMismatch as mismatch:
        name, reason = function_name(found), str(mismatch)
        kind = Kind.ACTION.value
        bag.add(
            messages.implementation_mismatch, symbol.span, name, kind, symbol.plan_name, reason, mismatch.expected
        )
        return
    made = replaced(made, variables=variables, optional=optional)
    declaration = Declaration(actor is not None, parameters)
    same = dict.fromkeys(parameters, _same)
    bound.actions[symbol.plan_name] = BoundAction(declaration, Mark(symbol.plan_name), adapt(made), same)


def _matched(found: Any, name: str, parameters: dict[str, ValueType], *, has_actor: bool) -> ActionClass:
    """Match the constructor and `execute` of a class with a declaration.

    Raises:
        SignatureMismatch: They differ.
    """
    known = [*parameters, *([ACTOR] if has_actor else [])]
    if not isinstance(found, type) or not callable(getattr(found, "update", None)):
        raise SignatureMismatch("expected a class with a method `update`")
    constructor = [name for name in _taken(found, "__init__") if name not in _OF_BASE]
    unknown = [name for name in constructor if name not in known]
    if unknown:
        raise SignatureMismatch(
            f"`__init__` takes {_listed(unknown)}; expected parameters of the action: {_listed(known)}"
        )
    rest = [name for name in parameters if name not in constructor]
    if not callable(getattr(found, "execute", None)):
        if rest:
            raise SignatureMismatch(
                f"neither `__init__` nor `execute` takes {_listed(rest)}", f"def execute(self, {', '.join(rest)})"
            )
        return ActionClass(found, name, tuple(constructor), ())
    expected = [*([ACTOR] if has_actor else []), *rest]
    executed = [name for name in _taken(found, "execute") if name != "self"]
    if sorted(executed) != sorted(expected):
        raise SignatureMismatch(
            f"`execute` takes {_listed(executed) or 'no parameters'}",
            f"def execute({', '.join(['self', *expected])})",
        )
    return ActionClass(found, name, tuple(constructor), tuple(executed))


def _taken(kind: type[Any], method: str) -> list[str]:
    """Return the names of the parameters of a method, without `*args` and `**kwargs`."""
    found = getattr(kind, method)
    if found is object.__init__:
        return []
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return [name for name, parameter in inspect.signature(found).parameters.items() if parameter.kind not in kinds]


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _hint(error: BaseException) -> str:
    name = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
    return f"install `{name}` beside seoro: the class needs it" if name else ""


def _same(value: Any) -> Any:
    return value
