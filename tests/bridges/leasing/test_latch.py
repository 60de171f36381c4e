"""The emergency stop: it holds until it is released with a reason, also over a restart."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.leasing.latch import ROOM, Latch
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


def test_who_stops_forges_no_line_of_a_message() -> None:
    latch = Latch()
    latch.stop(EmergencyStop(by="ana\nok", reason="smoke\x1b[2J\nok  the node x: stopped"))
    with pytest.raises(RequestRefused, match=r"by ana ok at .* \(smoke\ufffd\[2J ok the node x: stopped\)"):
        latch.check()
    assert "\n" not in latch.reason


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


def stop_of(*robots: str, by: str = "ana@lab", reason: str = "smoke") -> EmergencyStop:
    return EmergencyStop(by=by, reason=reason, robots=robots)


def test_robots_are_stopped_one_by_one_and_outlast_the_process(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    latch = Latch(file)
    latch.stop(stop_of("first", "second"))
    latch.stop(stop_of("second", by="bob"))
    latch.keep()
    for each in (latch, Latch(file)):
        each.check()
        each.check("third")
        assert (each.stopped, each.robots["second"].by) == (None, "ana@lab")
        with pytest.raises(RequestRefused, match=r"'second' does not move .* `seoro lab release --estop second "):
            each.check("third", "second")
    latch.release(ReleaseStop(by="bob", reason="toast", robots=("second",)))
    assert list(Latch(file).robots) == ["first"]
    latch.stop(SMOKE)
    latch.keep()
    both = Latch(file)
    assert both.stopped is not None
    assert list(both.robots) == ["first"]
    both.release(ReleaseStop(by="bob", reason="toast"))
    assert (Latch(file).stopped, dict(Latch(file).robots)) == (None, {})


def test_nothing_is_released_that_is_not_stopped_by_its_name() -> None:
    latch = Latch()
    latch.stop(stop_of("first"))
    with pytest.raises(RequestRefused, match="'second' is not stopped in an emergency: first"):
        latch.release(ReleaseStop(by="bob", reason="toast", robots=("first", "second")))
    assert list(latch.robots) == ["first"]
    latch.stop(SMOKE)
    with pytest.raises(RequestRefused, match="release it by `--all`"):
        latch.release(ReleaseStop(by="bob", reason="toast", robots=("first",)))


def test_stops_of_many_robots_fit_into_the_room_that_is_reserved(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    latch = Latch(file)
    robots = [f"robot-{number}" for number in range(40)]
    for robot in robots:
        latch.stop(stop_of(robot, by="\x00" * 500, reason=robot * 100))
        latch.keep()
    assert file.stat().st_size == ROOM
    again = Latch(file)
    assert (again.stopped, set(again.robots)) == (None, set(robots))
