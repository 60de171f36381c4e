"""Loading and checking scenario files, which takes nothing of what runs them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from seoro.bindings.implementations import BoundFunctions
from seoro.bindings.load import bind_sources
from seoro.embed.arguments import AnyPath, instance_of, to_modules, to_path
from seoro.errors import InvalidScenario
from seoro.lang.check.recall import BodyMessages
from seoro.lang.frontend import Checked
from seoro.lang.frontend import load as load_sources
from seoro.lang.loader import PARSERS, Parsers, Reader, Sources, read_file
from seoro.lang.recorder import Recorder
from seoro.located import Locate, as_named


@dataclass(frozen=True)
class Scenario:
    """A scenario file that has been checked.

    Args:
        checked: The file with all that it imports.
        functions: The functions that carry out actions and modifiers.
    """

    checked: Checked
    functions: BoundFunctions

    def __repr__(self) -> str:
        names = ", ".join(sorted(self.checked.scenarios)) or "no scenario"
        return f"<Scenario {self.checked.sources.entry.file.name}: {names}>"

    def without_errors(self) -> Scenario:
        """Itself.

        Raises:
            InvalidScenario: It has errors; the exception prints them with their places.
        """
        if self.checked.errors:
            raise InvalidScenario(self.checked.errors)
        return self


def check_file(
    path: str | Path,
    *,
    strict: bool = False,
    import_python: bool = True,
    modules: Iterable[ModuleType] = (),
    read: Reader = read_file,
    locate: Locate = as_named,
    recorder: Recorder | None = None,
    name: str | None = None,
    parsers: Parsers = PARSERS,
    known: BodyMessages | None = None,
    vet: Callable[[Sources], object] | None = None,
) -> Scenario:
    """Parse and check a file; errors in its text, and in what it is bound to, stand in `.checked.diagnostics`.

    Args:
        path: The file.
        strict: Report the use of extensions to the standard, too.
        import_python: Whether to import the Python modules of its libraries and external methods, which runs them,
            and to match them with declarations. Without them it cannot be run.
        modules: As `load`.
        read: Gives the texts of files.
        locate: Gives the places of those that are imported by absolute paths.
        recorder: Is told what names mean and of what types values are.
        name: How to call the file in messages; as its path unless said otherwise.
        parsers: Parse the files.
        known: What is known from an earlier check of the same file.
        vet: Called with what was read, before any Python is imported; what it raises comes out.
    """
    sources = load_sources(Path(path), name or str(path), read, locate, parsers)
    if vet is not None:
        vet(sources)
    bound = bind_sources(
        sources, strict=strict, is_own_only=not import_python, given=modules, recorder=recorder, known=known
    )
    return Scenario(bound.checked, bound.functions)


def load(path: AnyPath, *, modules: Iterable[ModuleType] = ()) -> Scenario:
    """Load a scenario file, and the Python modules of its libraries and external methods.

    Args:
        path: The file.
        modules: Python modules with actions, beside those of libraries, and before them.

    Raises:
        InvalidScenario: It has errors; the exception prints them with their places.
        InvalidUse: An argument is of a wrong type.
    """
    return check_file(to_path("path", path), modules=to_modules("modules", modules)).without_errors()


to_scenario = instance_of(Scenario, 'seoro.load("maze.osc")')
