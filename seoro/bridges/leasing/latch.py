"""The emergency stop of a node: who has stopped it, and that nothing moves until somebody releases it."""

from __future__ import annotations

import json
import logging
import os
import threading
import time
from datetime import datetime
from pathlib import Path

from seoro.bridges.wire.lab import MAX_TEXT, EmergencyStop, ReleaseStop, Stopped
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import LabResult, Result
from seoro.durable import sync_folder

ROOM = 16_384  # [bytes] of the file; a stop of the longest texts has less

log = logging.getLogger(__name__)


class Latch:
    """Whether an emergency stop holds; for any thread.

    Room for it on the disk is reserved while none holds, in a file beside its own: a disk that fills up later does
    not keep it from outlasting the process.

    Args:
        file: Where that is kept, so that it outlasts the process; None for nowhere. A file that cannot be read is
            taken for a stop.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._stopped = None if file is None or not file.exists() else _read(file)
        if self._stopped is None:
            self.keep()

    @property
    def stopped(self) -> Stopped | None:
        """The stop that holds."""
        return self._stopped

    @property
    def reason(self) -> str:
        """Why nothing moves, in words; empty if nothing speaks against it."""
        stopped = self._stopped
        return "" if stopped is None else f"emergency stop by {in_words(stopped)}"

    def stop(self, asked: EmergencyStop) -> None:
        """Let nothing move from now on. Who was first stays the one who has stopped it.

        Nothing is written yet, so that no disk delays it: `keep` does that.
        """
        with self._lock:
            if self._stopped is None:
                self._stopped = Stopped(by=asked.by[:MAX_TEXT], reason=asked.reason[:MAX_TEXT], since=time.time())

    def release(self, asked: ReleaseStop) -> None:
        """Let things move again.

        Raises:
            RequestRefused: No reason is given.
        """
        if not asked.reason.strip():
            raise RequestRefused(Result.OPERATION_FAILED, "an emergency stop is released with a reason: say why")
        if self._stopped is not None:
            log.warning("%s: released by %s: %s", self.reason, asked.by[:MAX_TEXT], asked.reason[:MAX_TEXT])
        with self._lock:
            self._stopped = None
        self.keep()

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

    def keep(self) -> None:
        """Write down whether a stop holds; what cannot be written is logged."""
        if self._file is None:
            return
        reserve = self._file.with_suffix(".reserve")
        try:
            with self._lock:
                if self._stopped is not None:
                    _write(self._file, reserve, json.dumps(self._stopped.model_dump()).encode())
                elif self._file.exists():
                    self._file.replace(reserve)
                elif not reserve.exists():
                    self._file.parent.mkdir(parents=True, exist_ok=True)
                    reserve.write_bytes(b" " * ROOM)
        except OSError as error:
            log.error("an emergency stop would not outlast a restart: %s", error)


def _write(file: Path, reserve: Path, text: bytes) -> None:
    """Write over what is there, which needs no room on the disk; what is left of it is blank."""
    place = file if file.exists() else reserve
    if not place.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        place.touch()
    with place.open("r+b", buffering=0) as kept:
        kept.write(text.ljust(ROOM))
        os.fsync(kept.fileno())
    if place != file:
        place.replace(file)
        sync_folder(file.parent)


def in_words(stopped: Stopped) -> str:
    """By whom, when and why something was stopped."""
    when = datetime.fromtimestamp(stopped.since).astimezone().strftime("%d %b %H:%M:%S")
    return f"{stopped.by} at {when}" + (f" ({stopped.reason})" if stopped.reason else "")


def _read(file: Path) -> Stopped:
    try:
        return Stopped.model_validate(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        return Stopped(by=f"a process before, as {file} says, which cannot be read: {error}", since=time.time())
