"""Cache of plans on disk, so that unchanged scenario files are not parsed and checked again.

There is one cached plan per scenario file and scenario. It is used only if all its sources are unchanged: the
texts of the file and its imports, and the parts of seoro that parse, check and bind. Scenarios with Python or
foreign libraries are not cached, since these may change unnoticed.

A cached plan is two lines of JSON: its sources, then the plan and its functions as `seoro.lang.plan_data`.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from seoro import __version__
from seoro.bindings.bound_functions import BoundFunctions
from seoro.embed.runnable import Entry, Runnable
from seoro.files.cache import cache_folder, digest_of, read_cached, write_cached
from seoro.files.inputs import Kind, read_input, resolved
from seoro.lang.frozen import Frozen
from seoro.lang.libraries import Origin, library_folders
from seoro.lang.plan import Call, CallMethod, Plan, ValueType
from seoro.lang.plan_data import PlanDataError, decode, encode, nodes
from seoro.lang.source import SourceFile
from seoro.runtime.functions.actions import ACTION_MARK, BoundAction, bind
from seoro.runtime.functions.fitting import Fitting
from seoro.runtime.functions.signatures import Declaration

if TYPE_CHECKING:
    from seoro.embed.scenarios import Scenario
    from seoro.runtime.functions.modifiers import BoundModifier

MAX_PLANS = 200  # the oldest are removed
_ROOT: Final = Path(__file__).parent.parent
_MAKERS: Final = (
    "actions",
    "bindings",
    "embed",
    "lang",
    "lang/check",
    "lang/library",
    "lang/lower",
    "lang/plan",
    "runtime/functions",
    "runtime/values",
)
_UNFIT: Final = (OSError, ValueError, AttributeError, PlanDataError)  # errors of plans that cannot be cached
_OWN_ACTIONS: Final = "seoro.actions."


def load_cached(path: Path, name: str | None) -> Runnable:
    """Load a scenario file to run one of its scenarios; read its plan from the cache, or add it.

    Args:
        path: The file.
        name: Name of the scenario; None for the entry of the file.

    Raises:
        InvalidScenario: The file has errors.
    """
    place = _place(path, name)
    found = _read(place, path) if place is not None else None
    if found is not None:
        return found
    from seoro.embed.scenarios import load  # noqa: PLC0415 - parser and checks, for files that are not cached

    scenario = load(path)
    return scenario if place is None else replace(scenario, on_plan=partial(_store, place))


def _place(path: Path, name: str | None) -> Path | None:
    """Return the path of the cached plan of a scenario; None if the user has no cache."""
    folder = cache_folder("plans")
    try:
        digest = digest_of(f"{path.absolute()}\n{path}\n{name}")
    except (OSError, UnicodeEncodeError):
        return None
    return folder / f"{digest}.plan" if folder is not None else None


@cache
def _makers() -> str:
    """Return the digest of seoro's version and of its files that make plans."""
    stamps = [f"{__version__} {sys.hexversion}"]
    for folder in _MAKERS:
        with os.scandir(_ROOT / folder) as entries:
            found = ((entry.name, entry.stat()) for entry in entries if entry.is_file())
            stamps += sorted(f"{name} {stat.st_size} {stat.st_mtime_ns}" for name, stat in found)
    return digest_of("\n".join(stamps))


# ---------------------------------------------------------------- reading


class _Cached(Frozen):
    """Scenario file with a cached plan."""

    file: SourceFile
    files: tuple[SourceFile, ...]
    scenario_lines: frozenset[int]
    found: Entry
    made: Plan
    functions: BoundFunctions

    def entry(self, name: str | None) -> Entry:
        """Return the entry; `name` is that of the cached plan."""
        return self.found

    def plan(self, name: str | None, overrides: Mapping[str, str], constraints: Sequence[str] = ()) -> Plan:
        """Return the cached plan, which is that of `name` without overrides and constraints."""
        assert not overrides and not constraints, "plans with these are not cached"
        return self.made


def _read(place: Path, path: Path) -> _Cached | None:
    """Read a cached plan; return None if it is missing or outdated."""
    content = read_cached(place)
    if content is None:
        return None
    try:
        if any(folder.exists() for folder in library_folders(path)):
            return None
        head, _, data = content.decode().partition("\n")
        makers, texts, lines, entry = json.loads(head)
        if makers != _makers():
            return None
        files = tuple(_source(*text) for text in texts)
        plan, has_calls, actions, modifiers = decode(data, files)
        if not isinstance(plan, Plan):
            return None
        functions = _bound(plan, has_calls, actions, modifiers)
        return _Cached(files[-1], files, frozenset(lines), Entry(*entry), plan, functions)
    except Exception:  # any: the file is parsed and checked again, which reports its errors
        return None


def _source(name: str, path: str, real_path: str, digest: str) -> SourceFile:
    """Read a source text again.

    Raises:
        OSError, ValueError: The text is missing or has changed.
    """
    text = read_input(Path(path), Kind.SCENARIO).decode().removeprefix("\ufeff")
    found = SourceFile(name, text, Path(path))
    if found.sha256 != digest or str(resolved(Path(path))) != real_path:
        raise ValueError(f"{path} has changed")
    return found


_Function = tuple[str, str, bool, dict[str, ValueType]]  # module, name, has an actor, types of parameters


def _bound(
    plan: Plan, has_calls: bool, actions: Mapping[str, _Function], modifiers: Mapping[str, _Function]
) -> BoundFunctions:
    """Bind the functions that a plan needs.

    Raises:
        Exception: A function is missing, or does not match.
    """
    structures = {structure.type.name: structure for structure in plan.structures.all()}
    fitting = Fitting(lambda name: {field.name: field.type for field in structures[name].fields.values()})
    if has_calls:
        from seoro.bindings.externals import bind_own_externals  # noqa: PLC0415 - for plans with calls only

        bind_own_externals(plan.methods, fitting)
    bound = BoundFunctions()
    for name, (module, attribute, has_actor, parameters) in actions.items():
        function = _find(module, attribute)
        mark = getattr(function, ACTION_MARK)
        bound.actions[name] = bind(Declaration(has_actor, parameters), mark, function, fitting)
    for name, (module, attribute, has_actor, parameters) in modifiers.items():
        from seoro.runtime.functions.modifiers import MODIFIER_MARK, bind_modifier  # noqa: PLC0415 - for few plans

        function = _find(module, attribute)
        if not hasattr(function, MODIFIER_MARK):
            raise ValueError(f"expected a modifier, found {attribute}")
        bound.modifiers[name] = bind_modifier(Declaration(has_actor, parameters), function, fitting)
    return bound


def _find(module: str, name: str) -> Callable[..., Any]:
    """Import a function of seoro's own actions.

    Raises:
        ValueError, ImportError, AttributeError: The function is missing or foreign.
    """
    if not module.startswith(_OWN_ACTIONS):
        raise ValueError(f"{module} is not a module of seoro")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found


# ---------------------------------------------------------------- writing


def _store(place: Path, scenario: Scenario, name: str | None, plan: Plan) -> None:
    """Cache a plan without overrides, if it can be cached."""
    if _is_own(scenario):
        with suppress(*_UNFIT):
            write_cached(place, _content(scenario, scenario.entry(name), plan))
            _remove_oldest(place.parent)


def _content(scenario: Scenario, entry: Entry, plan: Plan) -> bytes:
    """Serialise a plan with its sources.

    Raises:
        OSError, ValueError, AttributeError, PlanDataError: The plan cannot be cached.
    """
    files, functions = scenario.files, scenario.functions
    if not plan.actions.keys() <= functions.actions.keys():
        raise ValueError("an action has no implementation")
    texts = [(file.name, str(file.path), str(resolved(Path(str(file.path)))), file.sha256) for file in files]
    head = _makers(), texts, sorted(scenario.scenario_lines), (entry.name, entry.line)
    actions = {name: _described(functions.actions[name]) for name in plan.actions}
    modifiers = {
        name: _described(functions.modifiers[name]) for name in plan.modifiers if name in functions.modifiers
    }
    others = tuple(getattr(plan, name) for name in plan.__match_args__ if name != "methods")
    has_calls = any(isinstance(node, Call | CallMethod) for node in nodes(others))
    return f"{json.dumps(head)}\n{encode((plan, has_calls, actions, modifiers), files)}".encode()


def _described(bound: BoundAction | BoundModifier) -> _Function:
    """Serialise a function as its name and declaration."""
    function, declaration = bound.function, bound.declaration
    if _find(function.__module__, function.__qualname__) is not function:
        raise ValueError(f"{function} cannot be imported by its name")
    return function.__module__, function.__qualname__, declaration.has_actor, dict(declaration.parameters)


def _is_own(scenario: Scenario) -> bool:
    """Return whether a scenario uses only libraries and Python of seoro."""
    sources = scenario.checked.sources
    own = {module.file for module in sources.modules if module.library is not None}
    return (
        all(library.origin is Origin.OWN for library in sources.libraries)
        and all(external.span.file in own for _, external in scenario.checked.program.methods.externals())
        and scenario.files[-1] is scenario.file
        and all(file.path is not None for file in scenario.files)
    )


def _remove_oldest(folder: Path) -> None:
    """Remove the oldest plans beyond `MAX_PLANS`."""
    plans = sorted(folder.glob("*.plan"), key=lambda path: path.stat().st_mtime_ns, reverse=True)
    for path in plans[MAX_PLANS:]:
        path.unlink(missing_ok=True)
