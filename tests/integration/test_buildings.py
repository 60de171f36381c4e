"""`osc.buildings` on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.buildings
import osc.helpers

scenario main:
    timeout(60s)
    front: door
    second: door with:
        keep(it.entity == 'back')
    hoist: lift
    do serial:
        front.close()
        front.lock()
        front.unlock()
        parallel:
            front.open()
            front.wait_until_open(at_least: 0.5)
            hoist.move_to_floor(1)
            hoist.wait_until_at_floor(1)
            one_of:
                second.open(0.8)
                wait elapsed(0.5s)
        front.close()
        front.wait_until_closed()
        MORE
"""
WORLD = """
name: building
extent: [-3, -3, 3, 3]
doors:
  - {name: front, speed: 1.5}
  - {name: back, pose: {y: 2.5}, kind: sliding, side: right}
lifts:
  - {name: hoist, pose: {x: -2, y: -2}, floors: [0.0, 0.3]}
"""


def run(folder: Path, node: str, more: str) -> int:
    (folder / "building.yaml").write_text(WORLD)
    (folder / "buildings.osc").write_text(SCENARIO.replace("MORE", more))
    options = ["--connect", node, "--world", str(folder / "building.yaml"), "--rate", "max", "-o", str(folder)]
    return main(["exec", str(folder / "buildings.osc"), *options])


def test_a_scenario_moves_doors_and_lifts(tmp_path: Path, mujoco_node: str) -> None:
    assert run(tmp_path, mujoco_node, "wait elapsed(0.1s)") == 0
    records = read_trace(tmp_path / "trace.jsonl")
    names = {each["id"]: each["name"] for each in records if each["kind"] == "behavior.start"}
    ended = {(names[each["id"]], each["status"]) for each in records if each["kind"] == "behavior.end"}
    assert {
        ("front.open", "succeeded"),
        ("hoist.move_to_floor", "succeeded"),
        ("second.open", "cancelled"),
    } <= ended


def test_an_opening_beyond_the_end_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str
) -> None:
    assert run(tmp_path, mujoco_node, "front.open(1.5)") == 1
    assert "invalid opening 1.5 of a door; expected 0 (closed) to 1 (open)" in capsys.readouterr().err
