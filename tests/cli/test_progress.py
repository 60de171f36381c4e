"""The lines that show a run."""

from pathlib import Path

import anyio
import pytest

from seoro.cli.output import Progress


def lines(file: Path, *feedback: tuple[float, str, int]) -> list[str]:
    """Print navigation feedback of robots with numbers of recoveries; return the output."""

    async def show() -> None:
        with file.open("w", encoding="utf-8") as opened:
            progress = Progress(opened)
            for time, robot, recoveries in feedback:
                arguments = {"robot": robot, "number_of_recoveries": recoveries, "distance_remaining": 2.34}
                record = {"t": time, "kind": "event", "name": "navigation_feedback", "arguments": arguments}
                progress.record(record)
            await progress.finish()

    anyio.run(show)
    return file.read_text(encoding="utf-8").splitlines()


def test_a_robot_that_recovers_has_a_line(tmp_path: Path) -> None:
    shown = lines(tmp_path / "out", (1.0, "a", 0), (2.0, "a", 1), (3.0, "a", 1), (3.0, "b", 2), (9.0, "a", 0))
    assert shown == [
        "    2.000 s  ! a was blocked and is recovering, 2.3 m from its goal",
        "    3.000 s  ! b was blocked and is recovering, 2.3 m from its goal",
    ]


@pytest.mark.parametrize("again", [1, 2])
def test_recoveries_of_the_next_goal_are_counted_anew(tmp_path: Path, again: int) -> None:
    assert len(lines(tmp_path / "out", (1.0, "a", 2), (5.0, "a", 0), (6.0, "a", again))) == 2


@pytest.mark.parametrize("on_terminal", [True, False])
async def test_a_quiet_run_shows_what_goes_on(
    on_terminal: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("output._SHORT", "quiet_line.ON_TERMINAL", "quiet_line.IN_FILE", "quiet_line.REFRESH"):
        monkeypatch.setattr(f"seoro.cli.{name}", 0.0)
    monkeypatch.setattr("seoro.cli.output.is_terminal", lambda file: on_terminal)
    path = tmp_path / "out"
    with path.open("w", encoding="utf-8", newline="") as opened:
        progress = Progress(opened)
        for number, (kind, name) in enumerate([("modifier", "timeout"), ("action", "cart.nav_to_pose")]):
            progress.record({"kind": "behavior.start", "id": number, "type": kind, "name": name, "t": 1.0})
        arguments = {"robot": "cart", "number_of_recoveries": 0, "distance_remaining": 2.34}
        progress.record({"t": 2.0, "kind": "event", "name": "navigation_feedback", "arguments": arguments})
        progress.set_clock(lambda: 3.0)
        with anyio.fail_after(30.0):
            while "2.3 m left" not in path.read_text(encoding="utf-8"):
                await anyio.sleep(0.001)
        progress.record({"kind": "behavior.end", "id": 1, "status": "succeeded", "t": 4.0})
        await progress.finish()
    text = path.read_bytes().decode()
    line = "    3.000 s  cart.nav_to_pose; cart: 2.3 m left"
    end = "    4.000 s  + cart.nav_to_pose  succeeded after 3.00 s\n"
    plain = text.replace("\x1b[2m", "").replace("\x1b[32m", "").replace("\x1b[0m", "")
    assert f"\r\x1b[2K{line}\r\x1b[2K{end}" in plain if on_terminal else f"{line}\n{end}" in plain
