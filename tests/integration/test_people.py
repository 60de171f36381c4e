"""`osc.people` on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.people
import osc.helpers

scenario main:
    timeout(60s)
    guest: pedestrian
    second: pedestrian with:
        keep(it.entity == 'visitor')
    trolley: cart
    do serial:
        guest.appear(pose_3d(position_3d(x: 1m, y: -1m)), avoid: avoidance!none)
        parallel:
            guest.walk_along([position_2d(x: 1.5m, y: -1m), position_2d(x: 2m, y: -1m)])
            trolley.drive_along([position_2d(x: -1m, y: 1m)])
            one_of:
                second.patrol([position_2d(x: -2m, y: -1m), position_2d(x: -2m, y: -2m)], speed: 0.5mps)
                wait elapsed(2s)
        one_of:
            parallel:
                guest.wander(position_2d(x: 1m, y: -2m), position_2d(x: 2m, y: -1m))
                second.follow('guest')
                trolley.patrol([position_2d(x: -1m, y: 1m), position_2d(x: -1.5m, y: 1m)])
            wait elapsed(1s)
        second.stand()
        trolley.stand()
        MORE
"""
WORLD = """
name: square
extent: [-3, -3, 3, 3]
people:
  - {name: visitor, pose: {x: -2, y: -2}}
carts:
  - {name: trolley, size: [0.6, 0.4, 0.8], pose: {x: -2, y: 1}}
poses:
  - {name: exit, pose: {x: 2, y: 2}}
"""


def run(folder: Path, node: str, more: str) -> int:
    (folder / "square.yaml").write_text(WORLD)
    (folder / "people.osc").write_text(SCENARIO.replace("MORE", more))
    options = ["--connect", node, "--world", str(folder / "square.yaml"), "--rate", "max", "-o", str(folder)]
    return main(["exec", str(folder / "people.osc"), *options])


def test_a_scenario_moves_people_and_carts(tmp_path: Path, mujoco_node: str) -> None:
    assert run(tmp_path, mujoco_node, "guest.walk_to_place('exit')") == 0
    records = read_trace(tmp_path / "trace.jsonl")
    names = {each["id"]: each["name"] for each in records if each["kind"] == "behavior.start"}
    ended = [(names[each["id"]], each["status"]) for each in records if each["kind"] == "behavior.end"]
    assert ("guest.walk_along", "succeeded") in ended
    assert ("trolley.drive_along", "succeeded") in ended
    assert {("guest.wander", "cancelled"), ("second.follow", "cancelled"), ("trolley.patrol", "cancelled")} <= set(
        ended
    )


def test_a_way_out_of_the_world_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str
) -> None:
    assert run(tmp_path, mujoco_node, "guest.walk_to(position_2d(x: 9m, y: 0m))") == 1
    assert "(9, 0) is outside of the world; expected a point of its map" in capsys.readouterr().err
