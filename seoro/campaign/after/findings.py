"""Findings about failed runs, in files below the folder of a campaign, for its report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from seoro.campaign.store.folder import NEIGHBOURS, SHRINK
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input

SHRUNK: Final = "shrunk.json"
AROUND: Final = "neighbours.json"
MOST: Final = 50  # of each kind, in a report

_Finding = TypeVar("_Finding", bound=BaseModel)


class Shrunk(BaseModel):
    """Result of `seoro campaign shrink`.

    Attributes:
        run: Number of the failed run.
        reason: Reason of its failure.
        before: Values of its parameters by path, in the notation of the scenario.
        values: The simplest values found at which it fails the same way.
        simplest: Simplest values of the parameters.
        outcome: `minimal` if no parameter can be one step simpler, `failing` if there may be simpler values,
            `gone` if the failure did not repeat, `unconfirmed` if it was not repeated.
        best: Number of the run with `values`, in the campaign in the folder of this file; 0 without one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    run: int
    reason: str
    before: Mapping[str, str]
    values: Mapping[str, str]
    simplest: Mapping[str, str]
    outcome: Literal["minimal", "failing", "gone", "unconfirmed"]
    best: int

    @property
    def has_failed(self) -> bool:
        """Whether the run fails the same way with `values`."""
        return self.outcome in ("minimal", "failing")

    def matters(self, path: str) -> bool:
        """Return whether the failure needs another value of a parameter than the simplest."""
        return self.values[path] != self.simplest[path]


class Surrounding(BaseModel):
    """Surroundings of one parameter.

    Attributes:
        path: Its path.
        value: Its value in the failed run.
        below: Endings of runs with other values, or with smaller ones if they have an order.
        above: Endings of runs with greater values; empty if they have no order.
        matters: Whether the run does not fail the same way with some other value.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    path: str
    value: str
    below: str
    above: str
    matters: bool


class Surroundings(BaseModel):
    """Result of `seoro campaign neighbours`.

    Attributes:
        run: Number of the failed run.
        reason: Reason of its failure.
        parameters: Its parameters.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    run: int
    reason: str
    parameters: tuple[Surrounding, ...]


def write_finding(folder: Path, finding: Shrunk | Surroundings) -> None:
    """Write a finding to the folder of the campaign that it is from.

    Raises:
        OSError: It cannot be written.
    """
    name = SHRUNK if isinstance(finding, Shrunk) else AROUND
    (folder / name).write_text(finding.model_dump_json() + "\n", encoding="utf-8")


def read_shrunk(folder: Path) -> Iterator[Shrunk]:
    """Yield the results of `shrink` for runs of a campaign, by number, up to a number of results.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A file is invalid.
        OSError: It cannot be read.
    """
    return _read(folder / SHRINK, SHRUNK, Shrunk)


def read_surroundings(folder: Path) -> Iterator[Surroundings]:
    """Yield the results of `neighbours` for runs of a campaign; see `read_shrunk`."""
    return _read(folder / NEIGHBOURS, AROUND, Surroundings)


def _read(folder: Path, name: str, kind: type[_Finding]) -> Iterator[_Finding]:
    for path in sorted(folder.glob(f"*/{name}"))[:MOST]:
        try:
            yield kind.model_validate_json(read_input(path, Kind.OUTPUT))
        except ValidationError as error:
            raise UsageError(f"{path}: invalid result: {error.errors()[0]['msg']}", help="remove it") from error
