"""Actions of `osc.ros` that record and play bags."""

from dataclasses import replace
from pathlib import Path

import pytest

from seoro.bridges.ros2.recording import open_bag
from seoro.embed import prepare
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos, options
from tests.runtime.conftest import Ran, load_text


async def run_with_results(folder: Path, endpoint: str, text: str) -> Ran:
    scenario = load_text(folder, "import osc.ros\n" + text, ())
    settings = replace(options(endpoint), output_directory=folder / "out")
    async with prepare(scenario, settings) as run, run.running():
        records = [record async for record in run.trace()]
        return Ran(await run.result(), records)


async def test_a_run_is_recorded_and_played_again(tmp_path: Path, robot: str, router: str) -> None:
    ran = await run_with_results(
        tmp_path,
        robot,
        """
scenario main:
    do serial:
        bag_record(['/count', '/echo'], timestamp_suffix: false)
        wait elapsed(0.5s)
""",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    folder = tmp_path / "out" / "rosbag2"
    assert set(open_bag(folder).topics) == {"/count", "/echo"}
    assert f"in {folder}" in ran.logs[-1][1]
    again = await run_with_results(
        tmp_path,
        router,
        """
scenario main:
    event seen
    do parallel:
        serial:
            wait_for_data("/count", "std_msgs/msg/Int64")
            emit seen
        bag_play("out/rosbag2", ["/count"]) with:
            until @seen
            repeat()
""",
    )
    assert again.verdict.status is RunStatus.PASSED, again.verdict.reason


async def test_missing_topics_are_reported_with_their_names(tmp_path: Path, robot: str) -> None:
    ran = await run_with_results(
        tmp_path,
        robot,
        "scenario main:\n    do bag_record(['/count', '/nowhere']) with:\n        timeout(0.3s)\n",
    )
    assert ran.verdict.status is RunStatus.FAILED
    assert "`bag_record` ends without: /nowhere" in [text for _, text in ran.logs]


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (
            "bag_record(['/count'])",
            "no output folder for recorded topics; choose one with `-o`",
        ),
        ("bag_play('nowhere', ['/count'])", "nowhere"),
    ],
)
async def test_impossible_actions_are_reported(invocation: str, reason: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do {invocation}\n")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason


@pytest.mark.parametrize("storage", ["sqlite3", "csv"])
async def test_bags_are_recorded_in_a_storage_format(storage: str, tmp_path: Path, robot: str) -> None:
    text = f"scenario main:\n    do bag_record(['/count'], timestamp_suffix: false, storage: '{storage}')\n"
    ran = await run_with_results(tmp_path, robot, text)
    if storage == "csv":
        assert ran.verdict.status is RunStatus.FAILED
        assert "unsupported storage `csv`" in ran.verdict.reason
        return
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert set(open_bag(tmp_path / "out" / "rosbag2" / "rosbag2_0.db3").topics) == {"/count"}
