"""Files that a scenario names in string arguments of actions whose parameters are file names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from seoro.bundle.worlds import FILE_SCHEME, files_of_world, is_file_uri, is_world_file
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario
from seoro.embed.world_settings import constraints_of_scenario, split_world
from seoro.errors import UsageError
from seoro.files.world_names import WorldName
from seoro.lab.selectors import split_selectors
from seoro.lang.frontend import lower
from seoro.lang.plan import InvokeAction
from seoro.lang.plan.expressions import Literal
from seoro.lang.source import Span
from seoro.runtime.functions.actions import Mark


@dataclass(frozen=True)
class ReferencedFiles:
    """Files named in the text of a scenario.

    Args:
        paths: Files and folders.
        is_absolute: Whether they are named by absolute paths.
    """

    paths: Sequence[Path]
    is_absolute: bool


def referenced_files(scenario: Scenario, options: Options, folder: Path) -> Iterator[ReferencedFiles]:
    """Yield the files and folders that invocations of actions name by literals, without computed names.

    Args:
        scenario: Scenario, with seoro's own actions bound.
        options: Options of the run.
        folder: Folder of the scenario file, the base of relative paths.

    Raises:
        UsageError: A file is missing.
    """
    marks = {name: bound.mark for name, bound in scenario.functions.actions.items()}
    if not any(mark.files or mark.uris for mark in marks.values()):
        return
    overrides, _ = split_selectors(split_world(options.overrides)[0])
    constraints = constraints_of_scenario(options.constraints)
    plan = lower(scenario.checked, options.name, overrides, constraints)
    for invocation in plan.action_invocations():
        mark = marks.get(invocation.action)
        if mark is not None:
            yield from _named_by(invocation, mark, folder)


def _named_by(invocation: InvokeAction, mark: Mark, folder: Path) -> Iterator[ReferencedFiles]:
    for name, value in invocation.arguments:
        if not isinstance(value, Literal) or not isinstance(value.value, str):
            continue
        text = value.value
        if name in mark.uris and is_file_uri(text):
            path = Path(unquote(text.removeprefix(FILE_SCHEME)))
            yield ReferencedFiles([_existing(path, value.span)], is_absolute=True)
        elif name in mark.uris and _is_world_here(text):
            yield ReferencedFiles(files_of_world(text), Path(text).is_absolute())
        elif name in mark.files:
            yield ReferencedFiles([_existing(folder / text, value.span)], Path(text).is_absolute())


def _is_world_here(text: str) -> bool:
    """Return whether a text is a world file on this machine; others are files of the simulator."""
    return is_world_file(text) and Path(WorldName.parse(text).world).exists()


def _existing(path: Path, span: Span) -> Path:
    if not path.exists():
        raise UsageError(f"file not found: {path}", span)
    return path
