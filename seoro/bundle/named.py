"""Files that a scenario names in its own strings: actions say which of their parameters are names of files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from seoro.bundle.worlds import FILE_SCHEME, files_of_world, is_file_uri, is_world_file
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidUse
from seoro.lab.wishes import split_wishes
from seoro.lang.frontend import lower
from seoro.lang.plan import InvokeAction
from seoro.lang.plan.expressions import Literal
from seoro.lang.source import Span
from seoro.runtime.actions import Mark
from seoro.runtime.invocations import invocations


@dataclass(frozen=True)
class Named:
    """Files that are named in the text of a scenario.

    Args:
        paths: Files and folders.
        is_absolute: Whether they are named by an absolute path.
    """

    paths: Sequence[Path]
    is_absolute: bool


def named_files(scenario: Scenario, options: Options, folder: Path) -> Iterator[Named]:
    """The files and folders that invocations of actions name by literals; what is computed, the run knows only.

    Args:
        scenario: With seoro's own actions bound.
        options: How it is to be run.
        folder: Of the scenario file, beside which they lie.

    Raises:
        InvalidUse: One is not there.
    """
    marks = {name: bound.mark for name, bound in scenario.functions.actions.items()}
    if not any(mark.files or mark.uris for mark in marks.values()):
        return
    overrides, _ = split_wishes(options.overrides)
    for invocation in invocations(lower(scenario.checked, options.name, overrides)):
        mark = marks.get(invocation.action)
        if mark is not None:
            yield from _named_by(invocation, mark, folder)


def _named_by(invocation: InvokeAction, mark: Mark, folder: Path) -> Iterator[Named]:
    for name, value in invocation.arguments:
        if not isinstance(value, Literal) or not isinstance(value.value, str):
            continue
        text = value.value
        if name in mark.uris and is_file_uri(text):
            path = Path(unquote(text.removeprefix(FILE_SCHEME)))
            yield Named([_there(path, value.span)], is_absolute=True)
        elif name in mark.uris and is_world_file(text) and Path(text).exists():  # or it is where the simulator is
            yield Named(files_of_world(text), Path(text).is_absolute())
        elif name in mark.files:
            yield Named([_there(folder / text, value.span)], Path(text).is_absolute())


def _there(path: Path, span: Span) -> Path:
    if not path.exists():
        raise InvalidUse(f"there is no {path}", span)
    return path
