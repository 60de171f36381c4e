"""Running scenarios from Python, as the documentation shows it."""

import traceback
from dataclasses import fields
from pathlib import Path

import pytest

import seoro
from seoro.embed.options import OptionFields, Options

TEXT = """import osc.helpers
import osc.types

scenario greet:
    name: string = "world"
    do serial:
        log("hello " + name)
        wait elapsed(1h)
        log("bye")
"""


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    (tmp_path / "greet.osc").write_text(TEXT)
    return seoro.load(tmp_path / "greet.osc")


def test_the_keyword_arguments_of_start_are_the_options() -> None:
    assert list(OptionFields.__annotations__) == [field.name for field in fields(Options)]


async def test_a_run_executes_in_the_loop_of_the_caller(scenario: seoro.Scenario) -> None:
    async with seoro.start(scenario, seed=7, clock="virtual", overrides={"name": '"Ada"'}) as run:
        messages = [record["message"] async for record in run.trace() if record["kind"] == "log"]
    verdict = await run.result()
    assert messages == ["hello Ada", "bye"]
    assert verdict.passed
    assert (verdict.seed, verdict.duration) == (7, 3600.0)
    assert run.parameters == {"name": "Ada"}


async def test_a_missing_simulator_is_reported(scenario: seoro.Scenario) -> None:
    with pytest.raises(seoro.UsageError, match="unknown simulator 'gazebo'"):
        async with seoro.start(scenario, simulator=seoro.Simulator(name="gazebo")):
            pass


def test_all_errors_of_a_text_are_reported_at_once(tmp_path: Path) -> None:
    (tmp_path / "bad.osc").write_text("scenario main:\n    do serial:\n        one()\n        two()\n")
    with pytest.raises(seoro.InvalidScenario) as caught:
        seoro.load(tmp_path / "bad.osc")
    assert len(caught.value.diagnostics) == 2
    assert "bad.osc:3:9" in str(caught.value)
    assert "bad.osc:4:9" in str(caught.value)


async def test_a_traceback_contains_the_position_and_the_help(tmp_path: Path) -> None:
    (tmp_path / "robot.osc").write_text(
        "import osc.ros\nscenario main:\n    robot: differential_drive_robot\n"
        "    do robot.init_nav2(pose_3d(position_3d(x: 0.0m)))\n"
    )
    with pytest.raises(seoro.UsageError) as caught:
        async with seoro.start(seoro.load(tmp_path / "robot.osc")):
            pass
    shown = "".join(traceback.format_exception(caught.value))
    assert f"--> {tmp_path}/robot.osc:4:8\n" in shown
    assert "= help: start a simulator" in shown


async def test_an_error_of_a_text_has_its_code_and_positions(tmp_path: Path) -> None:
    file = tmp_path / "clash.osc"
    file.write_text("scenario main:\n    a: int\n    keep(a > 5)\n    keep(a < 3)\n    do emit end\n")
    with pytest.raises(seoro.UsageError) as caught:
        async with seoro.start(seoro.load(file), seed=1, clock="virtual"):
            pass
    text, error = str(caught.value), caught.value
    assert text.startswith("error[E0442]: these constraints cannot hold together") and "keep(a < 3)" in text
    assert (error.code, error.message) == ("E0442", "these constraints cannot hold together")
    assert error.diagnostic is not None and len(error.diagnostic.secondary) == 1
