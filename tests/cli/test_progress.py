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
