"""The emergency stop of a node: who has stopped it, and that nothing moves until somebody releases it."""

from __future__ import annotations

import json
import logging
import time
from datetime import datetime
from pathlib import Path

from seoro.bridges.wire.lab import MAX_TEXT, EmergencyStop, ReleaseStop, Stopped
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import LabResult, Result
from seoro.durable import sync_file, sync_folder

log = logging.getLogger(__name__)


class Latch:
    """Whether an emergency stop holds.

    Args:
        file: Where that is kept, so that it outlasts the process; None for nowhere. A file that cannot be read is
            taken for a stop.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._stopped = None if file is None or not file.exists() else _read(file)

    @property
    def stopped(self) -> Stopped | None:
        """The stop that holds."""
        return self._stopped

    @property
    def reason(self) -> str:
        """Why nothing moves, in words; empty if nothing speaks against it."""
        return "" if self._stopped is None else f"emergency stop by {in_words(self._stopped)}"

    def stop(self, asked: EmergencyStop) -> None:
        """Let nothing move from now on. Who was first stays the one who has stopped it."""
        if self._stopped is None:
            self._stopped = Stopped(by=asked.by[:MAX_TEXT], reason=asked.reason[:MAX_TEXT], since=time.time())
            self._write()

    def release(self, asked: ReleaseStop) -> None:
        """Let things move again.

        Raises:
            RequestRefused: No reason is given.
        """
        if not asked.reason.strip():
            raise RequestRefused(Result.OPERATION_FAILED, "an emergency stop is released with a reason: say why")
        if self._stopped is not None:
            log.warning("%s: released by %s: %s", self.reason, asked.by[:MAX_TEXT], asked.reason[:MAX_TEXT])
        self._stopped = None
        self._write()

    def check(self) -> None:
        """Refuse what moves something while the stop holds.

        Raises:
            RequestRefused: It does.
        """
        if self._stopped is not None:
            raise RequestRefused(
                LabResult.STOPPED,
                f"nothing moves since the {self.reason}; `seoro lab release --all --reason ...` ends that",
            )

    def sync(self) -> None:
        """Force the stop to the disk, so that it outlasts a loss of power; blocks."""
        if self._file is None or self._stopped is None:
            return
        try:
            sync_file(self._file)
            sync_folder(self._file.parent)
        except OSError as error:
            log.error("the emergency stop would not outlast a loss of power: %s", error)

    def _write(self) -> None:
        """Keep it; that a disk is full must not keep robots from being stopped."""
        if self._file is None:
            return
        try:
            if self._stopped is None:
                self._file.unlink(missing_ok=True)
            else:
                self._file.parent.mkdir(parents=True, exist_ok=True)
                self._file.write_text(json.dumps(self._stopped.model_dump()), encoding="utf-8")
        except OSError as error:
            log.error("the emergency stop would not outlast a restart: %s", error)


def in_words(stopped: Stopped) -> str:
    """By whom, when and why something was stopped."""
    when = datetime.fromtimestamp(stopped.since).astimezone().strftime("%d %b %H:%M:%S")
    return f"{stopped.by} at {when}" + (f" ({stopped.reason})" if stopped.reason else "")


def _read(file: Path) -> Stopped:
    try:
        return Stopped.model_validate(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        return Stopped(by=f"a process before, as {file} says, which cannot be read: {error}", since=time.time())
