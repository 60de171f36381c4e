"""Folder of a campaign.

| file | content |
|---|---|
| `campaign.json` | the bundle of the scenario, strategy, seed and versions |
| `asked.jsonl` | planned runs, written before they begin |
| `runs/WORKER.jsonl` | a row for each ended run, one file per worker |
| `kept/000123/` | trace and files of a run |
| `replayed/000123/` | results of a run that was repeated |
| `shrink/000123/`, `neighbours/000123/` | campaigns around a failed run |
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
from collections.abc import Collection, Container, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seoro.bridges.executor.messages import Manifest
from seoro.campaign.runs import Planned, Row, each_once
from seoro.campaign.store.covered import CoveredItem
from seoro.campaign.store.lines import Appender, cut_torn_line, read_lines
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input
from seoro.runtime.trace.jsonl import to_json

CAMPAIGN: Final = "campaign.json"
ASKED: Final = "asked.jsonl"
RUNS: Final = "runs"
COORDINATOR: Final = "coordinator"  # its shard has rows of runs that ended their workers
KEPT: Final = "kept"
TRACE: Final = "trace.jsonl"  # in the folder of a kept run
REPLAYED: Final = "replayed"
SHRINK: Final = "shrink"
NEIGHBOURS: Final = "neighbours"
UNREACHABLE: Final = "unreachable.jsonl"
LOCK: Final = "lock"
DERIVED: Final = ("runs.csv", "runs.parquet", "test.xml", "report.html", UNREACHABLE)  # can be made again
_NUMBER: Final = re.compile(rb'\{"number": ?(\d{1,18})\b')

Isolation = Literal["worker", "run", "process"]
Keep = Literal["failed", "all", "none"]


class StrategyText(BaseModel):
    """A strategy with its options, as in `campaign.json`."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    options: Annotated[dict[str, int | float | str | bool], Field(default_factory=dict)]


class CampaignFile(BaseModel):
    """Content of `campaign.json`.

    Attributes:
        manifest: Bundle of the scenario, with the options that all runs share.
        strategy: Strategy that chooses the values.
        runs: Number of runs; None for as many as the strategy has.
        repeat: Runs of each point, with the seeds `seed`, `seed + 1`, and so on.
        seed: Seed of the strategy and of the first repeat.
        keep: Runs that keep their trace and files; `failed` is all that did not pass.
        isolation: `worker` for runs in one process, `run` for a process per run, `process` for a new Python and a
            simulator per run, too.
        digest: Hash of all that determines the runs, see `seoro.campaign.identity`.
        simulator: Name and version of the simulator; empty without one.
        version: Version of seoro.
        until: Stopping rules, the first of which ends the campaign.
        budget: Wall time of a session [s]; None without a limit.
        seeds: Seeds of the repeats of each point, instead of consecutive ones; empty for those.
        parquet: Whether trajectories of kept runs are also written as Parquet.
        items: Definitions of the `cover` items of the scenario.
        is_sample: Whether the runs are a sample, so that their pass rate estimates a probability.
        is_extended: Whether the number of runs was changed after the start.
        requirements: Names of requirements that the scenario covers.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    manifest: Manifest
    strategy: StrategyText
    runs: int | None
    repeat: int
    seed: int
    keep: Keep
    isolation: Isolation
    digest: str
    simulator: str
    version: str
    until: tuple[str, ...] = ()
    budget: float | None = None
    seeds: tuple[int, ...] = ()
    parquet: bool = False
    items: tuple[CoveredItem, ...] = ()
    is_sample: bool = False
    is_extended: bool = False
    requirements: tuple[str, ...] = ()

    @property
    def has_fixed_runs(self) -> bool:
        """Whether the number of runs depends on no result."""
        return not self.until and self.budget is None and not self.is_extended


class CampaignFolder:
    """Open folder of a campaign, with a lock against other coordinators; close it at the end.

    Args:
        folder: The folder.
        campaign: Content of its `campaign.json`.
    """

    def __init__(self, folder: Path, campaign: CampaignFile) -> None:
        self.folder = folder
        self.campaign = campaign
        self._lock = _locked(folder)
        for shard in (folder / RUNS).glob("*.jsonl"):
            cut_torn_line(shard)
        self._asked = Appender(folder / ASKED)

    def ask(self, planned: list[Planned]) -> None:
        """Note planned runs, before they are handed out."""
        self._asked.append("".join(each.to_line() for each in planned))

    def asked(self, ended: Container[int] = ()) -> Iterator[Planned]:
        """Yield the planned runs of earlier sessions, in order.

        Args:
            ended: Numbers of runs to leave out, apart from the last one.

        Raises:
            UsageError: A line is invalid.
        """
        left_out: tuple[bytes, int] | None = None
        for place, line in enumerate(read_lines(self.folder / ASKED), start=1):
            number = _NUMBER.match(line)  # decoding all lines would take most of the time
            if number is not None and int(number[1]) in ended:
                left_out = line, place
            else:
                left_out = None
                yield _planned_in(line, self.folder, place)
        if left_out is not None:
            yield _planned_in(left_out[0], self.folder, left_out[1])

    def close(self) -> None:
        """Close its files, and release the lock."""
        self._asked.close()
        os.close(self._lock)

    def discard(self) -> None:
        """Close a campaign without rows, and remove its files."""
        self.close()
        _remove_campaign(self.folder)
        (self.folder / LOCK).unlink(missing_ok=True)
        with suppress(OSError):  # has other files
            self.folder.rmdir()


def create_folder(folder: Path, campaign: CampaignFile, *, overwrite: bool) -> CampaignFolder:
    """Create the folder of a new campaign.

    Raises:
        UsageError: It holds another campaign.
        OSError: It cannot be written.
    """
    if (folder / CAMPAIGN).exists():
        if not overwrite:
            raise UsageError(
                f"{folder} contains another campaign",
                help=f"continue it with `seoro campaign resume {folder}`, choose another folder with `-o`, or "
                "replace it with `--overwrite`",
            )
        os.close(_locked(folder))
        _remove_campaign(folder)
    (folder / RUNS).mkdir(parents=True, exist_ok=True)
    write_campaign(folder, campaign)
    return CampaignFolder(folder, campaign)


def _remove_campaign(folder: Path) -> None:
    for name in (RUNS, KEPT, REPLAYED, SHRINK, NEIGHBOURS):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in (ASKED, *DERIVED, CAMPAIGN):
        (folder / name).unlink(missing_ok=True)


def write_campaign(folder: Path, campaign: CampaignFile) -> None:
    """Write `campaign.json`, whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    written = folder / f".{CAMPAIGN}"
    written.write_text(to_json(campaign.model_dump(mode="json")) + "\n", encoding="utf-8")  # also infinite rates
    written.replace(folder / CAMPAIGN)


def read_campaign(folder: Path) -> CampaignFile:
    """Read `campaign.json`.

    Raises:
        UsageError: The folder is not that of a campaign.
    """
    path = folder / CAMPAIGN
    try:
        return CampaignFile.model_validate_json(read_input(path, Kind.OUTPUT))
    except OSError as error:
        raise UsageError(
            f"{folder} is not the folder of a campaign: {path.name}: {error.strerror}",
            help="start one with `seoro campaign run FILE -o FOLDER`",
        ) from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise UsageError(f"{path}: invalid at `{place}`: {first['msg']}") from error


def read_rows(folder: Path) -> Iterator[Row]:
    """Yield a row for each run that has ended, in no order.

    Raises:
        UsageError: A line is invalid.
    """
    return each_once(_all_rows(folder))


def _all_rows(folder: Path) -> Iterator[Row]:
    """Yield the rows of all shards."""
    for path in shards_of(folder):
        for number, line in enumerate(read_lines(path), start=1):
            yield row_in(line, f"{path}:{number}")


def shards_of(folder: Path) -> list[Path]:
    """Return the files with rows; those of workers come before the one about their deaths."""
    shards = (folder / RUNS).glob("*.jsonl")
    return sorted(shards, key=lambda path: (path.stem == COORDINATOR, path.name))


def row_in(line: bytes, place: str) -> Row:
    """Decode a line of a shard.

    Args:
        line: The line.
        place: Its place, for messages.

    Raises:
        UsageError: The line is invalid.
    """
    try:
        return Row.from_line(line)
    except (ValueError, TypeError, KeyError) as error:
        raise UsageError(f"{place}: invalid row: {error}") from error


def find_planned(folder: Path, numbers: Collection[int]) -> dict[int, Planned]:
    """Return planned runs by number; unknown numbers are left out.

    Args:
        folder: Folder of the campaign.
        numbers: Wanted numbers.

    Raises:
        UsageError: A wanted line is invalid.
    """
    found: dict[int, Planned] = {}
    for place, line in enumerate(read_lines(folder / ASKED), start=1):
        if len(found) == len(numbers):
            break
        first = _NUMBER.match(line)  # decoding all lines would take most of the time
        if first is None or int(first[1]) in numbers:
            planned = _planned_in(line, folder, place)
            if planned.number in numbers:
                found[planned.number] = planned
    return found


def _planned_in(line: bytes, folder: Path, place: int) -> Planned:
    try:
        return Planned.from_line(line)
    except (ValueError, TypeError) as error:
        raise UsageError(f"{folder / ASKED}:{place}: invalid line: {error}") from error


def _locked(folder: Path) -> int:
    """Lock a folder against other coordinators; returns the descriptor that holds the lock.

    Raises:
        UsageError: Another process runs a campaign there.
    """
    descriptor = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(descriptor)
        raise UsageError(
            f"another process runs the campaign in {folder}", help="wait for its end, or stop it with Ctrl-C"
        ) from None
    return descriptor


def shard(folder: Path, worker: str) -> Path:
    """Return the file for the rows of a worker."""
    return folder / RUNS / f"{worker}.jsonl"
