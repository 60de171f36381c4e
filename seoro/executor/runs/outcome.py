"""Outcome of a run whose process has ended, and the files that it leaves."""

from __future__ import annotations

import shutil
from contextlib import suppress
from typing import Final

from seoro.bridges.executor.messages import State
from seoro.embed.run_end import Ended, InvalidEnd, unpack_end
from seoro.executor.limits import MEBIBYTE, Limits
from seoro.executor.process import frames
from seoro.executor.runs.active_run import STOP_TIMEOUT, ActiveRun
from seoro.executor.runs.enforcement import KEPT_OF_CULPRIT
from seoro.executor.runs.usage import cut
from seoro.executor.storage.run_folder import RunFolder

_KILLED: Final = f"the run did not end within {STOP_TIMEOUT:g} s after it was stopped, and was killed"


def storage_error(error: OSError) -> str:
    """Return the message for a run whose files cannot be written."""
    return f"the executor cannot store the run: {error.strerror or error}"


def tidy(folder: RunFolder, limits: Limits, *, is_culprit: bool) -> None:
    """Remove temporary files of a run, and cut files that are too large."""
    shutil.rmtree(folder.home, ignore_errors=True)
    if is_culprit:
        cut(folder.trace, KEPT_OF_CULPRIT)
    if limits.log is not None:
        cut(folder.log, limits.log * MEBIBYTE)
    with suppress(OSError):
        if folder.log.lstat().st_size == 0:
            folder.log.unlink()


def outcome_of(end: bytes, code: int | None, live: ActiveRun) -> tuple[State, str]:
    """Return the final state and reason of a run whose process has ended."""
    if not end:
        match code:
            case frames.NOT_BEGUN if live.stop_reason is not None:
                return State.ERROR if live.is_aborted else State.CANCELLED, live.stop_reason
            case None:
                how = "ended"
            case _ if code < 0:
                how = f"was killed by signal {-code}"
            case _:
                how = f"ended with status {code}"
        if live.is_aborted:
            return State.ERROR, f"{live.stop_reason}; {_KILLED}"
        return State.ERROR, _KILLED if live.is_stopped else f"its process {how} before the run was over"
    try:
        found = unpack_end(end)
    except InvalidEnd as error:
        return State.ERROR, str(error)
    if isinstance(found, Ended):
        return State(found.verdict.status.value), found.verdict.reason
    if found.backend:
        return State.ERROR, found.backend
    reason = found.misuse.message if found.misuse is not None else found.diagnostics[0].message
    return State.INVALID, reason
