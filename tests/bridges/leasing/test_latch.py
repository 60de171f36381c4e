"""The emergency stop: it holds until it is released with a reason, also over a restart."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.leasing.latch import Latch
from seoro.bridges.wire.lab import EmergencyStop, ReleaseStop
from seoro.bridges.wire.refusal import RequestRefused

SMOKE = EmergencyStop(by="ana@lab", reason="smoke")


def test_nothing_moves_until_it_is_released_with_a_reason(tmp_path: Path) -> None:
    latch = Latch(tmp_path / "state" / "stop.json")
    latch.check()
    latch.stop(SMOKE)
    latch.stop(EmergencyStop(by="somebody else"))
    with pytest.raises(RequestRefused, match=r"nothing moves since the emergency stop by ana@lab at .* \(smoke\)"):
        latch.check()
    with pytest.raises(RequestRefused, match="say why"):
        latch.release(ReleaseStop(by="bob", reason=" "))
    latch.release(ReleaseStop(by="bob", reason="toast"))
    latch.check()


def test_it_outlasts_the_process(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    latch = Latch(file)
    latch.stop(SMOKE)
    latch.keep()
    again = Latch(file)
    assert again.stopped is not None
    assert again.stopped.by == "ana@lab"
    again.release(ReleaseStop(by="bob", reason="toast"))
    assert Latch(file).stopped is None


def test_a_file_that_cannot_be_read_is_a_stop(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    file.write_text("{")
    with pytest.raises(RequestRefused, match="cannot be read"):
        Latch(file).check()


def test_a_file_that_cannot_be_written_does_not_keep_it_from_stopping(tmp_path: Path) -> None:
    (tmp_path / "in the way").write_text("")
    latch = Latch(tmp_path / "in the way" / "stop.json")
    latch.stop(SMOKE)
    latch.keep()
    assert latch.stopped is not None


def test_a_stop_is_kept_on_a_disk_without_room(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    latch = Latch(file)
    size = file.with_suffix(".reserve").stat().st_size
    longest = EmergencyStop(by="\x00" * 500, reason="\U0001f525" * 500)
    for asked in (longest, SMOKE):
        latch.stop(asked)
        latch.keep()
        assert (file.stat().st_size, list(tmp_path.iterdir())) == (size, [file])  # in the room that was reserved
        again = Latch(file).stopped
        assert again is not None
        assert (again.by, again.reason) == (asked.by, asked.reason)
        latch.release(ReleaseStop(by="bob", reason="toast"))
        assert Latch(file).stopped is None
