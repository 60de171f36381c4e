"""Runs of a campaign as scenario files, each of which runs by itself.

Such a file has the text of the scenario, with directives for seed, simulator, world and parameters directly above
the scenario that runs. A folder of such files also has copies of the libraries, imports and other files that lie
with the scenario. Imports from elsewhere are named relative to that folder.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

from seoro.bundle.pack import pack
from seoro.embed.directives import directive_comments
from seoro.embed.options import ROS_SIMULATOR, Options
from seoro.embed.parameter_files import read_parameters
from seoro.embed.scenarios import Scenario
from seoro.embed.world_settings import constraints_of_scenario
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input, resolved
from seoro.files.world_names import WorldName
from seoro.lang.ast import ImportUri
from seoro.lang.frozen import Value
from seoro.lang.loader import Module
from seoro.lang.source import SourceFile

MARK: Final = "# Written by seoro campaign"  # begins the comment of each file, so that it may be replaced
_KEPT: Final = ("expect", "timeout")  # directives that stay true for a single run

Edit: TypeAlias = tuple[int, int, str]
"""Offsets of a text, and the new text between them."""


class Emitted(Value):
    """Written scenario file.

    Args:
        path: The file.
        lines: Its line for each line of the original, both from 1; 0 for removed lines.
    """

    path: Path
    lines: tuple[int, ...]

    def line_of(self, original: int) -> int:
        """Return the line of a line of the original, both from 1."""
        return self.lines[original - 1]


class Emitter:
    """Writes runs of a scenario as files to one folder.

    Args:
        scenario: Result of `load`.
        options: Options that all runs share.
        folder: Folder of the files; created if missing.

    Raises:
        UsageError: A file that the scenario needs is missing, or would replace another one in the folder.
        OSError: A file cannot be written.
    """

    def __init__(self, scenario: Scenario, options: Options, folder: Path) -> None:
        self._scenario = scenario
        self._options = options
        self._folder = resolved(folder)
        entry = scenario.entry(options.name)
        self._line = entry.line
        given = {} if options.parameters is None else read_parameters(options.parameters, entry.name)
        self._shared = {**given, **options.overrides}
        folder.mkdir(parents=True, exist_ok=True)
        self._copy_files()

    def write(self, name: str, values: Mapping[str, str], seed: int, note: Sequence[str] = ()) -> Emitted:
        """Write a run.

        Args:
            name: Name of the file, with `.osc`.
            values: Values of parameters by path, in the notation of the scenario.
            seed: Seed of the run.
            note: Lines of a comment, without `#`.

        Raises:
            UsageError: A file of this name was not written by a campaign.
            OSError: The file cannot be written.
        """
        path = self._folder / name
        check_replaceable(path)
        module = self._scenario.checked.sources.entry
        file = module.file
        comments = [MARK + ".", *(f"# {line}" for line in note)]
        comments += [f"# seoro: {each}" for each in self._directives(values, seed)]
        removed = list(self._replaced_lines(file))
        edits: list[Edit] = [*self._imports(module)]
        edits += [(file.start_of_line(each), _end_of_line(file, each), "") for each in removed]
        start = file.start_of_line(self._line)
        edits.append((start, start, "".join(f"{line}\n" for line in comments)))
        path.write_text(_edited(file.text, edits), encoding="utf-8", newline="")
        return Emitted(path, tuple(_lines(file.line_count, removed, self._line, len(comments))))

    def remove_others(self, stem: str, names: Collection[str]) -> None:
        """Remove files that a campaign wrote to the folder before.

        Args:
            stem: Beginning of their names.
            names: Names of files to keep.

        Raises:
            OSError: A file cannot be removed.
        """
        for path in self._folder.glob(f"{glob.escape(stem)}_*.osc"):
            if path.name not in names and MARK.encode() in read_input(path, Kind.SCENARIO):
                path.unlink()

    def _directives(self, values: Mapping[str, str], seed: int) -> Iterator[str]:
        simulator = self._options.simulator
        if simulator is not None and simulator.name != ROS_SIMULATOR:
            yield from [] if simulator.name is None else [f"simulators {simulator.name}"]
            yield from [] if simulator.world is None else [f"world {self._world(simulator.world)}"]
        yield f"seed {seed}"
        for parameter, text in {**self._shared, **values}.items():
            yield f"set {parameter}={_in_one_line(text)}"
        for constraint in constraints_of_scenario(self._options.constraints):
            yield f"constrain {_in_one_line(constraint)}"

    def _world(self, text: str) -> str:
        world = WorldName.parse(text)
        if not Path(world.world).is_file():
            return text
        return str(world.replaced(os.path.relpath(resolved(Path(world.world)), self._folder)))

    def _replaced_lines(self, file: SourceFile) -> Iterator[int]:
        """Yield the lines of directives that the new ones replace, or that concern other scenarios."""
        others = self._scenario.scenario_lines - {self._line}
        for number, _, kind, text in directive_comments(file):
            below = next((line for line in range(number, file.line_count + 1) if not _is_comment(file, line)), 0)
            if below in others or (kind == "seoro" and text.split(" ")[0] not in _KEPT):
                yield number

    # ------------------------------------------------------------ other files of the scenario

    def _copy_files(self) -> None:
        """Copy the files of the scenario that lie with it."""
        file = self._scenario.file
        assert file.path is not None, "scenarios of campaigns are files"
        home = resolved(file.path.parent)
        if home == self._folder:
            return
        own = pack(self._scenario, Options(name=self._options.name, overrides=self._options.overrides))
        modules = {
            resolved(module.file.path): module
            for module in self._scenario.checked.sources.modules
            if module.file.path is not None
        }
        root = Path(own.manifest.root or ".")
        for each in own.manifest.files:
            source = resolved(root / each.path)
            if source == resolved(file.path) or not source.is_relative_to(home):
                continue
            content = read_input(source, Kind.BUNDLED)
            module = modules.get(source)
            if module is not None:
                content = _edited(module.file.text, self._imports(module)).encode()
            _place(self._folder / source.relative_to(home), content)

    def _imports(self, module: Module) -> Iterator[Edit]:
        """Yield the changes of imports that name files elsewhere by relative paths."""
        path = self._scenario.file.path
        assert path is not None and module.file.path is not None, "modules are files"
        home = resolved(path.parent)
        around = resolved(module.file.path.parent)
        if home == self._folder:
            return
        for statement in module.tree.statements:
            if not isinstance(statement, ImportUri) or ":" in statement.uri or Path(statement.uri).is_absolute():
                continue
            imported = resolved(around / statement.uri)
            if not imported.is_relative_to(home):
                place = self._folder / around.relative_to(home)
                uri = os.path.relpath(imported, place)
                span = statement.span
                yield span.start, span.end, span.text.replace(statement.uri, uri)


def _in_one_line(text: str) -> str:
    return " ".join(line.strip() for line in text.splitlines())


def check_replaceable(path: Path) -> None:
    """Check that a file can be written: it is missing, or was written by a campaign.

    Raises:
        UsageError: It is another file.
    """
    if path.exists() and MARK.encode() not in read_input(path, Kind.SCENARIO):
        raise UsageError(
            f"{path} exists, and was not written by seoro campaign", help="remove it, or choose another file"
        )


def _place(path: Path, content: bytes) -> None:
    if path.exists():
        if read_input(path, Kind.OUTPUT) != content:
            raise UsageError(
                f"{path} exists, and differs from the file of the scenario", help="choose a new folder"
            )
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _is_comment(file: SourceFile, line: int) -> bool:
    return file.line(line).lstrip().startswith("#")


def _end_of_line(file: SourceFile, line: int) -> int:
    return file.start_of_line(line + 1) if line < file.line_count else len(file.text)


def _edited(text: str, edits: Sequence[Edit] | Iterator[Edit]) -> str:
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _lines(count: int, removed: Sequence[int], inserted_at: int, inserted: int) -> Iterator[int]:
    """Yield the new line of each line."""
    shift = 0
    for line in range(1, count + 1):
        if line == inserted_at:
            shift += inserted
        if line in removed:
            shift -= 1
            yield 0
        else:
            yield line + shift
