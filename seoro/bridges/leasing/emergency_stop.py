"""Emergency stops of a node or of some of its robots, until they are released."""

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

from seoro.bridges.wire.lab import MAX_TEXT, ActiveStop, EmergencyStop, ReleaseStop
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.bridges.wire.results import LabResult, Result
from seoro.files.durable import sync_folder
from seoro.text.printable import one_line

FILE_SIZE: Final = 16_384  # [bytes], more than a stop with the longest texts
TEXT_LIMITS: Final = (MAX_TEXT, 100, 20)  # [characters], tried in order until all stops fit into the file
RELEASE_ALL: Final = "`seoro lab release --all --reason ...`"
RELEASE_ONE: Final = "`seoro lab release --estop {robot} --reason ...`"

log = logging.getLogger(__name__)


class EmergencyStopState:
    """Active emergency stops, of a whole node and of single robots; for any thread.

    Without a stop, a second file reserves disk space. So stops outlast the process even if the disk fills up.

    Args:
        file: File in which stops outlast the process; None to keep them in memory only. An unreadable file counts
            as a stop of the whole node.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._stopped: ActiveStop | None = None
        self._robots: Mapping[str, ActiveStop] = {}  # replaced, never changed: it is read without the lock
        if file is not None and file.exists():
            self._stopped, self._robots = _read(file)
        else:
            self.save()

    @property
    def stopped(self) -> ActiveStop | None:
        """Stop of the whole node."""
        return self._stopped

    @property
    def robots(self) -> Mapping[str, ActiveStop]:
        """Stops of single robots, by their names."""
        return self._robots

    @property
    def reason(self) -> str:
        """Reason why no robot may move; empty if movement is allowed."""
        return "" if self._stopped is None else _reason(self._stopped)

    def reason_of(self, robot: str) -> str:
        """Return the reason why a robot may not move; empty if movement is allowed."""
        stopped = self._stopped or self._robots.get(robot)
        return "" if stopped is None else _reason(stopped)

    def stop(self, request: EmergencyStop) -> None:
        """Stop robots, or everything if none is named. Earlier stops of a robot stay.

        The disk would delay the stop: call `save` afterwards.
        """
        stopped = ActiveStop(by=request.by[:MAX_TEXT], reason=request.reason[:MAX_TEXT], since=time.time())
        with self._lock:
            if request.robots:
                self._robots = dict.fromkeys(request.robots, stopped) | dict(self._robots)
            elif self._stopped is None:
                self._stopped = stopped

    def release(self, request: ReleaseStop) -> None:
        """Release robots, or everything if none is named.

        Raises:
            RequestRefused: The reason is missing, or a robot has no stop of its own.
        """
        if not request.reason.strip():
            raise RequestRefused(Result.OPERATION_FAILED, "missing reason to release an emergency stop: give one")
        with self._lock:
            self._check_released(request.robots)
            for reason in self._reasons(request.robots):
                log.warning("%s: released by %s: %s", reason, request.by[:MAX_TEXT], request.reason[:MAX_TEXT])
            if not request.robots:
                self._stopped, self._robots = None, {}
            self._robots = {robot: stop for robot, stop in self._robots.items() if robot not in request.robots}
        self.save()

    def _check_released(self, robots: tuple[str, ...]) -> None:
        for robot in robots:
            if self._stopped is not None:
                raise RequestRefused(
                    LabResult.STOPPED, f"everything is stopped, not only '{robot}': release it by {RELEASE_ALL}"
                )
            if robot not in self._robots:
                known = f" (stopped: {name_list(self._robots)})" if self._robots else ""
                raise RequestRefused(Result.NOT_FOUND, f"no emergency stop of the robot '{robot}'{known}")

    def _reasons(self, robots: tuple[str, ...]) -> Iterator[str]:
        if self._stopped is not None:
            yield self.reason
        for robot, stopped in self._robots.items():
            if not robots or robot in robots:
                yield f"{_reason(stopped)} of '{robot}'"

    def check(self, *robots: str) -> None:
        """Check that no stop prevents robots from moving.

        Raises:
            RequestRefused: The whole node or one of the robots is stopped.
        """
        if self._stopped is not None:
            raise RequestRefused(
                LabResult.STOPPED, f"no robot may move: {self.reason}; release it by {RELEASE_ALL}"
            )
        for robot in robots:
            if robot in self._robots:
                how = RELEASE_ONE.format(robot=robot)
                raise RequestRefused(
                    LabResult.STOPPED,
                    f"the robot '{robot}' may not move: {self.reason_of(robot)}; release it by {how}",
                )

    def save(self) -> None:
        """Write the active stops to the file; failures are logged."""
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
                    reserve.write_bytes(b" " * FILE_SIZE)
        except OSError as error:
            log.error("cannot store emergency stops, so they would not outlast a restart: %s", error)


def selected_robots(named: Iterable[str], robots: Iterable[str]) -> tuple[str, ...]:
    """Return the robots of a node that an emergency stop names, or all if it names none.

    Raises:
        RequestRefused: None of the named robots is at this node.
    """
    here, wanted = tuple(robots), frozenset(named)
    found = tuple(robot for robot in here if not wanted or robot in wanted)
    if wanted and not found:
        raise RequestRefused(
            Result.NOT_FOUND, f"unknown robots: {name_list(wanted)} (robots here: {name_list(here)})"
        )
    return found


def describe_stop(stopped: ActiveStop) -> str:
    """Describe a stop: person, time and reason."""
    when = datetime.fromtimestamp(stopped.since).astimezone().strftime("%d %b %H:%M:%S")
    return one_line(f"{stopped.by} at {when}" + (f" ({stopped.reason})" if stopped.reason else ""))


def _reason(stopped: ActiveStop) -> str:
    return f"emergency stop by {describe_stop(stopped)}"


# ---------------------------------------------------------------- the file


def _encoded(everything: ActiveStop | None, robots: Mapping[str, ActiveStop]) -> bytes:
    """Return the content of the file: the stop of everything, and under `robots` the others with their robots.

    If they do not fit, texts are shortened, never the list of robots.
    """
    names: dict[ActiveStop, list[str]] = {}
    for robot, stop in robots.items():
        names.setdefault(stop, []).append(robot)
    text = b""
    for limit in TEXT_LIMITS:
        content: dict[str, Any] = {} if everything is None else _shortened(everything, limit)
        content["robots"] = [{**_shortened(stop, limit), "of": of} for stop, of in names.items()]
        text = json.dumps(content).encode()
        if len(text) <= FILE_SIZE:
            break
    return text


def _shortened(stop: ActiveStop, limit: int) -> dict[str, Any]:
    return {"by": stop.by[:limit], "reason": stop.reason[:limit], "since": stop.since}


def _write(file: Path, reserve: Path, text: bytes) -> None:
    """Overwrite the file or the reserved one, padded with blanks, which needs no further disk space."""
    target = file if file.exists() else reserve
    if not target.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        target.touch()
    with target.open("r+b", buffering=0) as stream:
        stream.write(text.ljust(FILE_SIZE))
        stream.truncate(max(FILE_SIZE, len(text)))  # it may have been longer
        os.fsync(stream.fileno())
    if target != file:
        target.replace(file)
        sync_folder(file.parent)


def _read(file: Path) -> tuple[ActiveStop | None, dict[str, ActiveStop]]:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
        stops = content.get("robots", [])
        robots = {robot: ActiveStop.model_validate(stop) for stop in stops for robot in stop["of"]}
        everything = ActiveStop.model_validate(content) if "by" in content or not robots else None
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        cause = f"an earlier process ({file} cannot be read): {error}"
        return ActiveStop(by=cause, since=time.time()), {}
    return everything, robots
