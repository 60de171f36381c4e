"""Arguments of the Python API: conversions, and errors with the expected type."""

import asyncio
import math
import os
from pathlib import Path
from typing import Any

import pytest

import seoro
from seoro.embed.options import OptionFields, options_from

ENDPOINT = "tcp/[::1]:1"  # unused
LOGIC = """import osc.types
scenario main:
    n: int = 1
    s: string = 'x'
    l: list of int = [1]
    do wait elapsed(1s)
"""


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    (tmp_path / "logic.osc").write_text(LOGIC)
    return seoro.load(os.fspath(tmp_path / "logic.osc"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"simulator": "mujoco"}, "expected a seoro.Simulator, found 'mujoco' (str)"),
        ({"lab": "hall.yaml"}, "expected a seoro.Lab"),
        ({"ros": "tcp/[::1]:1"}, "expected a seoro.Ros"),
        ({"leasing": 3.0}, "expected a seoro.Leasing"),
        ({"overrides": {"n": object()}}, "overrides['n']: expected a bool, a finite number, a text or a list"),
        ({"overrides": {"n": math.inf}}, "overrides['n']: expected"),
        ({"overrides": "n=3"}, "invalid `overrides`: expected a mapping"),
        ({"overrides": {3: "3"}}, "invalid `a key of overrides`: expected a str"),
        ({"seed": "x"}, "invalid `seed`: expected a whole number (int), found 'x' (str)"),
        ({"seed": True}, "invalid `seed`: expected a whole number"),
        ({"name": 3}, "invalid `name`: expected a str"),
        ({"clock": 3}, "invalid `clock`: expected a str"),
        ({"grace": "5"}, "invalid `grace`: expected a number"),
        ({"parameters": 3}, "invalid `parameters`: expected a path"),
        ({"output_directory": b"out"}, "invalid `output_directory`: expected a path"),
        ({"observers": print}, "invalid `observers`: expected a list of objects with a method `record`"),
        ({"keep_trace": "no"}, "invalid `keep_trace`: expected True or False"),
        ({"vet": 3}, "invalid `vet`: expected a function"),
        ({"sim": "mujoco"}, "unknown option `sim`"),
    ],
)
def test_an_invalid_option_is_rejected_with_the_expected_type(
    scenario: seoro.Scenario, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(seoro.UsageError) as caught:
        seoro.run(scenario, **options)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: seoro.Simulator(name="mujoco", rate="fast"), 'invalid `rate`: expected a number or "max"'),  # type: ignore[arg-type]
        (lambda: seoro.Simulator(name=3), "invalid `name`: expected a str, found 3 (int)"),  # type: ignore[arg-type]
        (lambda: seoro.Simulator(name="mujoco", model_path="models"), "expected a list of paths, found 'models'"),
        (lambda: seoro.Simulator(name="mujoco", model_path=[3]), "invalid `model_path[0]`: expected a path"),  # type: ignore[list-item]
        (lambda: seoro.Lab(3), "invalid `file`: expected a path"),  # type: ignore[arg-type]
        (lambda: seoro.Ros("tcp/[::1]:1", domain="3"), "invalid `domain`: expected a whole number"),  # type: ignore[arg-type]
        (lambda: seoro.Leasing(wait="long"), "invalid `wait`: expected a number"),  # type: ignore[arg-type]
        (
            lambda: seoro.Simulator(name="mujoco", rate=-1.0),
            "invalid `rate`: found -1.0, expected a number above 0",
        ),
        (lambda: seoro.Lab("hall.yaml", rate=math.nan), "invalid `rate`: found nan, expected a number above 0"),
        (lambda: seoro.Leasing(wait=math.nan), "invalid `wait`: found nan, expected seconds from 0"),
        (lambda: seoro.Leasing(wait=-1.0), "invalid `wait`: found -1.0, expected seconds from 0"),
        (lambda: seoro.Leasing(on_wait=3), "invalid `on_wait`: expected a function"),  # type: ignore[arg-type]
        (lambda: seoro.Leasing(on_acquired=3), "invalid `on_acquired`: expected a function"),  # type: ignore[arg-type]
        (lambda: seoro.load("a.osc", modules=math), "invalid `modules`: expected a list of modules"),  # type: ignore[arg-type]
        (lambda: seoro.load("a.osc", modules=["math"]), "invalid `modules[0]`: expected a module"),  # type: ignore[list-item]
        (lambda: seoro.action(print), "invalid `name` of `@seoro.action`: expected a str"),  # type: ignore[call-overload]
        (lambda: seoro.action("a")(3), "`@seoro.action` expects a function, found 3"),  # type: ignore[arg-type]
        (lambda: seoro.modifier(print), "invalid `name` of `@seoro.modifier`: expected a str"),  # type: ignore[arg-type]
        (lambda: seoro.modifier("a")(3), "`@seoro.modifier` expects a function"),  # type: ignore[arg-type]
        (lambda: seoro.Client(3), "invalid `endpoint`: expected a str"),  # type: ignore[arg-type]
        (lambda: seoro.Client(keys=3), "invalid `keys`: expected a path"),  # type: ignore[arg-type]
        (lambda: seoro.Client(patience="long"), "invalid `patience`: expected a number"),  # type: ignore[arg-type]
        (lambda: seoro.Client().lab(3), "invalid `file`: expected a path"),  # type: ignore[arg-type]
        (lambda: seoro.Client().lab(connect=ENDPOINT), "invalid `connect`: expected a list of str"),
        (lambda: seoro.load(3), "invalid `path`: expected a path"),  # type: ignore[arg-type]
        (lambda: seoro.run("maze.osc"), "expected a seoro.Scenario, found 'maze.osc'"),  # type: ignore[arg-type]
    ],
)
def test_a_wrong_argument_is_refused_where_it_is_given(make: Any, message: str) -> None:
    with pytest.raises(seoro.UsageError) as caught:
        make()
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda client, _: client.submit("a", "a.osc", priority="high"), "invalid `priority`: expected a whole"),
        (
            lambda client, _: client.submit("a", "a.osc", stop_if_lost="5"),
            "invalid `stop_if_lost`: expected a number",
        ),
        (
            lambda client, _: client.submit("a", "a.osc", film=True),
            "invalid `film`: expected a seoro.embed.video.VideoOptions",
        ),
        (lambda client, _: client.dry_run("a", 3), "invalid `scenario`: expected a path"),
        (lambda client, _: client.describe(3), "invalid `executor`: expected a str"),
        (lambda client, _: client.run(3), "invalid `run`: expected a str"),
        (lambda client, _: client.runs(limit="all"), "invalid `limit`: expected a whole number"),
        (lambda client, _: client.revoke("a.crl"), "invalid `revoked`: expected bytes, found 'a.crl' (str)"),
        (lambda _, lab: lab.lease(), "expected names of robots"),
        (lambda _, lab: lab.lease(["tb1"]), "invalid `robots[0]`: expected a str, found ['tb1'] (list)"),
        (lambda _, lab: lab.lease("tb1", duration="60"), "invalid `duration`: expected a number"),
        (
            lambda _, lab: lab.lease("tb1", duration=-1.0),
            "invalid `duration`: found -1.0, expected seconds above 0",
        ),
        (lambda _, lab: lab.lease("tb1", purpose=3), "invalid `purpose`: expected a str"),
        (lambda _, lab: lab.release(3), "invalid `name`: expected a str"),
        (lambda _, lab: lab.stop(), "expected names of robots"),
        (lambda _, lab: lab.stop(["tb1"]), "invalid `robots[0]`: expected a str"),
        (lambda _, lab: lab.stop_all(3), "invalid `reason`: expected a str"),
        (lambda _, lab: lab.estop(["tb1"]), "invalid `robots[0]`: expected a str"),
        (lambda _, lab: lab.estop("tb1", reason=3), "invalid `reason`: expected a str"),
        (lambda _, lab: lab.release_all(3), "invalid `reason`: expected a str"),
        (lambda _, lab: lab.release_estop("tb1", reason=3), "invalid `reason`: expected a str"),
    ],
)
def test_clients_refuse_wrong_arguments_before_they_ask_anybody(call: Any, message: str) -> None:
    client = seoro.Client(ENDPOINT)
    with pytest.raises(seoro.UsageError) as caught:
        asyncio.run(call(client, client.lab(connect=[ENDPOINT])))
    assert message in str(caught.value)


def test_paths_may_be_texts_and_rates_as_on_the_command_line() -> None:
    simulator = seoro.Simulator(
        name="mujoco", world=Path("hall.yaml"), rate="max", model_path=["models"], snapshot="s"
    )
    assert simulator == seoro.Simulator(
        name="mujoco", world="hall.yaml", rate=math.inf, model_path=[Path("models")], snapshot=Path("s")
    )
    assert seoro.Lab("hall.yaml").file == Path("hall.yaml")
    assert options_from(OptionFields(parameters="p.yaml", output_directory="out")).parameters == Path("p.yaml")
    assert seoro.Simulator(name="ros", world="file:///world.sdf").world == "file:///world.sdf"


def test_overrides_take_values_of_python_and_expressions(scenario: seoro.Scenario) -> None:
    async def parameters(overrides: dict[str, object]) -> dict[str, object]:
        async with seoro.start(scenario, clock="virtual", overrides=overrides) as run:
            return run.parameters

    found = asyncio.run(parameters({"n": 3, "s": "'y'", "l": [4, 5]}))
    assert (found["n"], found["s"], list(found["l"])) == (3, "y", [4, 5])  # type: ignore[call-overload]


def test_objects_print_in_a_line(scenario: seoro.Scenario) -> None:
    assert repr(scenario).startswith("<Scenario ")
    assert repr(scenario).endswith("logic.osc: main>")
    assert repr(seoro.run(scenario, clock="virtual")) == "<Verdict of main: passed>"


def test_completion_lists_the_public_names() -> None:
    assert dir(seoro) == sorted([*seoro.__all__, "__version__"])
