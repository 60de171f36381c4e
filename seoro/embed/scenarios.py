"""Loading and checking of scenario files, without the runtime."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from types import ModuleType

from seoro.bindings.bind import bind_sources
from seoro.bindings.bound_functions import BoundFunctions
from seoro.embed.arguments import AnyPath, instance_of, to_modules, to_path
from seoro.embed.directives import top_scenarios
from seoro.embed.runnable import Entry
from seoro.errors import InvalidScenario
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.lang.check.body_cache import BodyMessages
from seoro.lang.frontend import Checked
from seoro.lang.frontend import load as load_sources
from seoro.lang.frozen import Value
from seoro.lang.loader import PARSERS, Parsers, Reader, Sources, read_file
from seoro.lang.lower.lower import Plans, find_entry
from seoro.lang.plan import Plan
from seoro.lang.program import Recorder
from seoro.lang.source import SourceFile


class Scenario(Value):
    """Checked scenario file.

    Args:
        checked: The file with all its imports.
        functions: Functions that implement actions and modifiers.
        on_plan: Called with the scenario, and the name and the plan of each plan without changes, if any.
        plans: Plans by the given name of the entry, created on demand.
    """

    checked: Checked
    functions: BoundFunctions
    on_plan: Callable[[Scenario, str | None, Plan], object] | None = None
    plans: dict[str | None, Plans] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        names = ", ".join(sorted(self.checked.scenarios)) or "no scenario"
        return f"<Scenario {self.checked.sources.entry.file.name}: {names}>"

    def _repr_html_(self) -> str:
        """Return the scenarios of the file with their parameters for notebooks."""
        from seoro.text.notebook import card, table_html  # noqa: PLC0415 - for notebooks only

        rows = []
        for symbol in top_scenarios(self.checked):
            fields = symbol.inventory.fields.values()
            parameters = ", ".join(found.text for found in fields if not found.is_variable)
            rows.append((symbol.name, symbol.span.line, parameters))
        table = table_html(("scenario", "line", "parameters"), rows) if rows else ""
        errors = len(self.checked.errors)
        return card(self.file.name, "invalid" if errors else "", {"errors": errors or None}, table=table)

    def without_errors(self) -> Scenario:
        """Return the scenario itself.

        Raises:
            InvalidScenario: The scenario has errors; the exception prints them with their places.
        """
        if self.checked.errors:
            raise InvalidScenario(self.checked.errors)
        return self

    @property
    def file(self) -> SourceFile:
        """The file."""
        return self.checked.sources.entry.file

    @property
    def files(self) -> tuple[SourceFile, ...]:
        """The file and all its imports."""
        return tuple(module.file for module in self.checked.sources.modules)

    @property
    def scenario_lines(self) -> frozenset[int]:
        """The lines of the file that name its own scenarios, from 1."""
        return frozenset(symbol.span.line for symbol in top_scenarios(self.checked))

    def entry(self, name: str | None) -> Entry:
        """Find the scenario to run, as `Runnable.entry`."""
        symbol = find_entry(self.checked, name)
        return Entry(symbol.qualified_name, symbol.span.line)

    def plan(self, name: str | None, overrides: Mapping[str, str], constraints: Sequence[str] = ()) -> Plan:
        """Make the plan of a scenario, as `Runnable.plan`."""
        if name not in self.plans:
            self.plans[name] = Plans(self.checked, name)
        plan = self.plans[name].with_overrides(overrides, constraints)
        if self.on_plan is not None and not overrides and not constraints:
            self.on_plan(self, name, plan)
        return plan


def check_file(
    path: str | Path,
    *,
    strict: bool = False,
    import_python: bool = True,
    modules: Iterable[ModuleType] = (),
    read: Reader = read_file,
    locate: Locate = unchanged_path,
    recorder: Recorder | None = None,
    name: str | None = None,
    parsers: Parsers = PARSERS,
    known: BodyMessages | None = None,
    vet: Callable[[Sources], object] | None = None,
) -> Scenario:
    """Parse and check a file, and bind its Python; errors are in `.checked.diagnostics`.

    Args:
        path: The file.
        strict: Whether to report extensions to the standard, too.
        import_python: Whether to import (and thereby run) the Python modules of its libraries and external
            methods, and to match them with declarations. Without them, the scenario cannot be run.
        modules: As `load`.
        read: Function that reads the text of a file.
        locate: Function that maps absolute paths of imports.
        recorder: Recorder of the meanings of names and the types of values.
        name: Name of the file in messages; by default its path.
        parsers: Parsers of the files.
        known: Messages from an earlier check of the same file.
        vet: Called with the sources before any Python is imported; its exceptions propagate.
    """
    sources = load_sources(Path(path), name or str(path), read, locate, parsers)
    if vet is not None:
        vet(sources)
    bound = bind_sources(
        sources, strict=strict, is_own_only=not import_python, given=modules, recorder=recorder, known=known
    )
    return Scenario(*bound)


def load(path: AnyPath, *, modules: Iterable[ModuleType] = ()) -> Scenario:
    """Load a scenario file, and the Python modules of its libraries and external methods.

    Args:
        path: The file.
        modules: Python modules with actions; they take precedence over those of libraries.

    Raises:
        InvalidScenario: The scenario has errors; the exception prints them with their places.
        UsageError: An argument has a wrong type.
    """
    return check_file(to_path("path", path), modules=to_modules("modules", modules)).without_errors()


to_scenario = instance_of(Scenario, "a seoro.Scenario", 'for example seoro.load("maze.osc")')
