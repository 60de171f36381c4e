"""Files that a scenario names in its own strings: actions say which of their parameters are names of files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidUse
from seoro.lang.frontend import lower
from seoro.lang.plan import InvokeAction
from seoro.lang.plan.expressions import Literal
from seoro.runtime.actions import Mark
from seoro.runtime.invocations import invocations

_FILE_SCHEME = "file://"


def named_files(scenario: Scenario, options: Options, folder: Path) -> Iterator[Path]:
    """The files and folders that invocations of actions name by literals; what is computed, the run knows only.

    Args:
        scenario: With seoro's own actions bound.
        options: How it is to be run.
        folder: Of the scenario file, beside which they lie.

    Raises:
        InvalidUse: One is not there, or is named in a way that holds on this machine only.
    """
    marks = {name: bound.mark for name, bound in scenario.functions.actions.items()}
    if not any(mark.files or mark.uris for mark in marks.values()):
        return
    for invocation in invocations(lower(scenario.checked, options.name, options.overrides)):
        mark = marks.get(invocation.action)
        if mark is not None:
            yield from _named_by(invocation, mark, folder)


def _named_by(invocation: InvokeAction, mark: Mark, folder: Path) -> Iterator[Path]:
    for name, value in invocation.arguments:
        if not isinstance(value, Literal) or not isinstance(value.value, str):
            continue
        text = value.value
        if name in mark.uris and (text.startswith(_FILE_SCHEME) or Path(text).is_absolute()):
            raise InvalidUse(
                f"`{name}` names a file of this machine, which is not there on another",
                value.span,
                "name a model as `name://path`, and the folder with `--model-path`",
            )
        if name in mark.files:
            path = Path(text)
            if path.is_absolute():
                raise InvalidUse(
                    f"`{name}` is an absolute path, which is not there on another machine",
                    value.span,
                    "name it by a path relative to the scenario file",
                )
            if not (folder / path).exists():
                raise InvalidUse(f"there is no {folder / path}", value.span)
            yield folder / path
