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
    Latch(file).stop(SMOKE)
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
    assert latch.stopped is not None
