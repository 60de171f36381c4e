"""The emergency stop of a node: who has stopped it or some of its robots, until somebody releases that."""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from seoro.bridges.wire.lab import MAX_TEXT, EmergencyStop, ReleaseStop, Stopped
from seoro.bridges.wire.refusal import RequestRefused, listed
from seoro.bridges.wire.results import LabResult, Result
from seoro.durable import sync_folder
from seoro.terminal_text import one_line

ROOM: Final = 16_384  # [bytes] of the file; one stop of the longest texts has less
SHORTER: Final = (MAX_TEXT, 100, 20)  # [characters] of texts in the file, until all stops fit into it
ALL: Final = "--all"  # options of `seoro lab release`
ONE: Final = "--estop {robot}"

log = logging.getLogger(__name__)


class Latch:
    """Emergency stops that hold, of a whole node and of single robots; for any thread.

    Room for them on the disk is reserved while none holds, in a file beside its own: a disk that fills up later
    does not keep them from outlasting the process.

    Args:
        file: Where they are kept, so that they outlast the process; None for nowhere. A file that cannot be read
            is taken for a stop of everything.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._stopped: Stopped | None = None
        self._robots: Mapping[str, Stopped] = {}  # replaced as a whole, never changed: others read it unlocked
        if file is not None and file.exists():
            self._stopped, self._robots = _read(file)
        else:
            self.keep()

    @property
    def stopped(self) -> Stopped | None:
        """The stop of everything that holds."""
        return self._stopped

    @property
    def robots(self) -> Mapping[str, Stopped]:
        """The stops of single robots that hold, by their names."""
        return self._robots

    @property
    def reason(self) -> str:
        """Why nothing moves, in words; empty if nothing speaks against it."""
        return "" if self._stopped is None else _reason(self._stopped)

    def reason_of(self, robot: str) -> str:
        """Why a robot does not move, in words; empty if nothing speaks against it."""
        stopped = self._stopped or self._robots.get(robot)
        return "" if stopped is None else _reason(stopped)

    def stop(self, asked: EmergencyStop) -> None:
        """Stop robots, or everything if none is named. Who was first stays the one who has stopped them.

        Nothing is written yet, so that no disk delays it: `keep` does that.
        """
        stopped = Stopped(by=asked.by[:MAX_TEXT], reason=asked.reason[:MAX_TEXT], since=time.time())
        with self._lock:
            if asked.robots:
                self._robots = dict.fromkeys(asked.robots, stopped) | dict(self._robots)
            elif self._stopped is None:
                self._stopped = stopped

    def release(self, asked: ReleaseStop) -> None:
        """Let robots move again, or everything if none is named.

        Raises:
            RequestRefused: No reason is given, or one of the robots is not stopped by itself.
        """
        if not asked.reason.strip():
            raise RequestRefused(Result.OPERATION_FAILED, "an emergency stop is released with a reason: say why")
        with self._lock:
            self._check_released(asked.robots)
            for reason in self._reasons(asked.robots):
                log.warning("%s: released by %s: %s", reason, asked.by[:MAX_TEXT], asked.reason[:MAX_TEXT])
            if not asked.robots:
                self._stopped, self._robots = None, {}
            self._robots = {robot: each for robot, each in self._robots.items() if robot not in asked.robots}
        self.keep()

    def _check_released(self, robots: tuple[str, ...]) -> None:
        for robot in robots:
            if self._stopped is not None:
                raise RequestRefused(
                    LabResult.STOPPED, f"everything is stopped, not only '{robot}': release it by `{ALL}`"
                )
            if robot not in self._robots:
                known = f": {listed(self._robots)}" if self._robots else ""
                raise RequestRefused(
                    Result.NOT_FOUND, f"the robot '{robot}' is not stopped in an emergency{known}"
                )

    def _reasons(self, robots: tuple[str, ...]) -> Iterator[str]:
        if self._stopped is not None:
            yield self.reason
        for robot, stopped in self._robots.items():
            if not robots or robot in robots:
                yield f"{_reason(stopped)} of '{robot}'"

    def check(self, *robots: str) -> None:
        """Refuse what moves robots while a stop of everything holds, or one of these robots.

        Raises:
            RequestRefused: It does.
        """
        if self._stopped is not None:
            raise RequestRefused(
                LabResult.STOPPED, f"nothing moves since the {self.reason}; {_release_by(ALL)} ends that"
            )
        for robot in robots:
            if robot in self._robots:
                raise RequestRefused(
                    LabResult.STOPPED,
                    f"the robot '{robot}' does not move since the {self.reason_of(robot)}; "
                    f"{_release_by(ONE.format(robot=robot))} ends that",
                )

    def keep(self) -> None:
        """Write down which stops hold; what cannot be written is logged."""
        if self._file is None:
            return
        reserve = self._file.with_suffix(".reserve")
        try:
            with self._lock:
                if self._stopped is not None or self._robots:
                    _write(self._file, reserve, _encoded(self._stopped, self._robots))
                elif self._file.exists():
                    self._file.replace(reserve)
                elif not reserve.exists():
                    self._file.parent.mkdir(parents=True, exist_ok=True)
                    reserve.write_bytes(b" " * ROOM)
        except OSError as error:
            log.error("an emergency stop would not outlast a restart: %s", error)


def named_here(asked: Iterable[str], robots: Iterable[str]) -> tuple[str, ...]:
    """Find the robots of a node that an emergency stop is for: those that it names, or all.

    Raises:
        RequestRefused: It names none of them.
    """
    here, wanted = tuple(robots), frozenset(asked)
    found = tuple(robot for robot in here if not wanted or robot in wanted)
    if wanted and not found:
        raise RequestRefused(Result.NOT_FOUND, f"unknown robots: {listed(wanted)} (robots here: {listed(here)})")
    return found


def _release_by(option: str) -> str:
    return f"`seoro lab release {option} --reason ...`"


def in_words(stopped: Stopped) -> str:
    """By whom, when and why something was stopped."""
    when = datetime.fromtimestamp(stopped.since).astimezone().strftime("%d %b %H:%M:%S")
    return one_line(f"{stopped.by} at {when}" + (f" ({stopped.reason})" if stopped.reason else ""))


def _reason(stopped: Stopped) -> str:
    return f"emergency stop by {in_words(stopped)}"


# ---------------------------------------------------------------- the file


def _encoded(everything: Stopped | None, robots: Mapping[str, Stopped]) -> bytes:
    """The text of the file: the stop of everything, and under `robots` each of the others with its robots.

    Where that is too long, texts of people are cut: what is stopped matters more.
    """
    together: dict[Stopped, list[str]] = {}
    for robot, stopped in robots.items():
        together.setdefault(stopped, []).append(robot)
    text = b""
    for longest in SHORTER:
        kept: dict[str, Any] = {} if everything is None else _shortened(everything, longest)
        kept["robots"] = [{**_shortened(stopped, longest), "of": names} for stopped, names in together.items()]
        text = json.dumps(kept).encode()
        if len(text) <= ROOM:
            break
    return text


def _shortened(stopped: Stopped, longest: int) -> dict[str, Any]:
    return {"by": stopped.by[:longest], "reason": stopped.reason[:longest], "since": stopped.since}


def _write(file: Path, reserve: Path, text: bytes) -> None:
    """Write over what is there, which needs no room on the disk; what is left of it is blank."""
    place = file if file.exists() else reserve
    if not place.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        place.touch()
    with place.open("r+b", buffering=0) as kept:
        kept.write(text.ljust(ROOM))
        kept.truncate(max(ROOM, len(text)))  # it may have been longer
        os.fsync(kept.fileno())
    if place != file:
        place.replace(file)
        sync_folder(file.parent)


def _read(file: Path) -> tuple[Stopped | None, dict[str, Stopped]]:
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        together = kept.get("robots", [])
        robots = {robot: Stopped.model_validate(each) for each in together for robot in each["of"]}
        everything = Stopped.model_validate(kept) if "by" in kept or not robots else None
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        why = f"a process before, as {file} says, which cannot be read: {error}"
        return Stopped(by=why, since=time.time()), {}
    return everything, robots
