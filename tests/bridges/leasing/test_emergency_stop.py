"""Emergency stop: it holds until its release with a reason, also over a restart."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.leasing.emergency_stop import FILE_SIZE, EmergencyStopState
from seoro.bridges.wire.lab import EmergencyStop, ReleaseStop
from seoro.bridges.wire.refusal import RequestRefused

SMOKE = EmergencyStop(by="ana@lab", reason="smoke")


def test_commands_are_refused_until_the_stop_is_released_with_a_reason(tmp_path: Path) -> None:
    emergency = EmergencyStopState(tmp_path / "state" / "stop.json")
    emergency.check()
    emergency.stop(SMOKE)
    emergency.stop(EmergencyStop(by="somebody else"))
    with pytest.raises(RequestRefused, match=r"no robot may move: emergency stop by ana@lab at .* \(smoke\)"):
        emergency.check()
    with pytest.raises(RequestRefused, match="missing reason"):
        emergency.release(ReleaseStop(by="bob", reason=" "))
    emergency.release(ReleaseStop(by="bob", reason="toast"))
    emergency.check()


def test_line_breaks_in_a_stop_reason_are_replaced() -> None:
    emergency = EmergencyStopState()
    emergency.stop(EmergencyStop(by="ana\nok", reason="smoke\x1b[2J\nok  the node x: stopped"))
    with pytest.raises(RequestRefused, match=r"by ana ok at .* \(smoke\ufffd\[2J ok the node x: stopped\)"):
        emergency.check()
    assert "\n" not in emergency.reason


def test_an_emergency_stop_outlasts_the_process(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    emergency = EmergencyStopState(file)
    emergency.stop(SMOKE)
    emergency.save()
    again = EmergencyStopState(file)
    assert again.stopped is not None
    assert again.stopped.by == "ana@lab"
    again.release(ReleaseStop(by="bob", reason="toast"))
    assert EmergencyStopState(file).stopped is None


def test_an_invalid_state_file_counts_as_a_stop(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    file.write_text("{")
    with pytest.raises(RequestRefused, match="cannot be read"):
        EmergencyStopState(file).check()


def test_an_unwritable_state_file_does_not_prevent_a_stop(tmp_path: Path) -> None:
    (tmp_path / "in the way").write_text("")
    emergency = EmergencyStopState(tmp_path / "in the way" / "stop.json")
    emergency.stop(SMOKE)
    emergency.save()
    assert emergency.stopped is not None


def test_a_stop_is_saved_on_a_full_disk(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    emergency = EmergencyStopState(file)
    size = file.with_suffix(".reserve").stat().st_size
    longest = EmergencyStop(by="\x00" * 500, reason="\U0001f525" * 500)
    for asked in (longest, SMOKE):
        emergency.stop(asked)
        emergency.save()
        assert (file.stat().st_size, list(tmp_path.iterdir())) == (size, [file])  # in the room that was reserved
        again = EmergencyStopState(file).stopped
        assert again is not None
        assert (again.by, again.reason) == (asked.by, asked.reason)
        emergency.release(ReleaseStop(by="bob", reason="toast"))
        assert EmergencyStopState(file).stopped is None


def stop_of(*robots: str, by: str = "ana@lab", reason: str = "smoke") -> EmergencyStop:
    return EmergencyStop(by=by, reason=reason, robots=robots)


def test_stops_of_single_robots_outlast_the_process(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    emergency = EmergencyStopState(file)
    emergency.stop(stop_of("first", "second"))
    emergency.stop(stop_of("second", by="bob"))
    emergency.save()
    for each in (emergency, EmergencyStopState(file)):
        each.check()
        each.check("third")
        assert (each.stopped, each.robots["second"].by) == (None, "ana@lab")
        with pytest.raises(RequestRefused, match=r"'second' may not move: .* `seoro lab release --estop second "):
            each.check("third", "second")
    emergency.release(ReleaseStop(by="bob", reason="toast", robots=("second",)))
    assert list(EmergencyStopState(file).robots) == ["first"]
    emergency.stop(SMOKE)
    emergency.save()
    both = EmergencyStopState(file)
    assert both.stopped is not None
    assert list(both.robots) == ["first"]
    both.release(ReleaseStop(by="bob", reason="toast"))
    assert (EmergencyStopState(file).stopped, dict(EmergencyStopState(file).robots)) == (None, {})


def test_releasing_a_robot_without_a_stop_of_its_own_is_refused() -> None:
    emergency = EmergencyStopState()
    emergency.stop(stop_of("first"))
    with pytest.raises(RequestRefused, match=r"robot 'second' \(stopped: first"):
        emergency.release(ReleaseStop(by="bob", reason="toast", robots=("first", "second")))
    assert list(emergency.robots) == ["first"]
    emergency.stop(SMOKE)
    with pytest.raises(RequestRefused, match="release it by `seoro lab release --all"):
        emergency.release(ReleaseStop(by="bob", reason="toast", robots=("first",)))


def test_stops_of_many_robots_fit_into_the_reserved_file(tmp_path: Path) -> None:
    file = tmp_path / "stop.json"
    emergency = EmergencyStopState(file)
    robots = [f"robot-{number}" for number in range(40)]
    for robot in robots:
        emergency.stop(stop_of(robot, by="\x00" * 500, reason=robot * 100))
        emergency.save()
    assert file.stat().st_size == FILE_SIZE
    again = EmergencyStopState(file)
    assert (again.stopped, set(again.robots)) == (None, set(robots))
