"""Scenarios of the cookbook answer their questions, and fail when the shown feature is broken."""

from __future__ import annotations

import re
import shlex
from contextlib import nullcontext
from pathlib import Path

import pytest

import seoro
from seoro.cli.main import main
from tests.routers import routing
from tests.tools.reference.cookbook import FOLDER, ROOT, Recipe, Variation, cookbook, recipes

RECIPES = recipes()
ENDPOINT = "tcp/127.0.0.1:7447"
MOST_LINES = 30


def broken(recipe: Recipe, variation: Variation) -> object:
    """Parameters of a test, marked if they start a simulator."""
    is_simulated = "--rate" in recipe.command
    marks = [pytest.mark.more, pytest.mark.engine("mujoco")] if is_simulated else []
    return pytest.param(recipe, variation, marks=marks, id=recipe.file.stem)


@pytest.fixture(autouse=True)
def in_the_repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder that looks like the root of the repository."""
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)


def run(command: str) -> int:
    """Run a command, with a router of ROS 2 if it names one, and return its exit status."""
    with routing() if ENDPOINT in command else nullcontext("") as endpoint:
        return main(shlex.split(command.replace(ENDPOINT, endpoint))[1:])


def test_there_are_thirty_recipes_without_warnings(capsys: pytest.CaptureFixture[str]) -> None:
    assert len(RECIPES) == 30
    assert main(["check", "scenarios/cookbook"]) == 0
    assert "warning" not in capsys.readouterr().err


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.file.stem)
def test_a_recipe_is_a_question_with_an_answer_and_a_short_scenario(recipe: Recipe) -> None:
    assert recipe.question.endswith("?")
    assert re.search(r" Passes( with .*)?\.$", recipe.answer)
    assert recipe.source.count("\n") <= MOST_LINES
    assert f"### {recipe.question}\n\n{recipe.answer}\n\n`{recipe.file.name}`:" in cookbook()


@pytest.mark.parametrize(
    ("recipe", "variation"),
    [broken(recipe, each) for recipe in RECIPES for each in recipe.variations],
)
def test_a_recipe_does_not_pass_when_broken_for_the_shown_reason(
    recipe: Recipe, variation: Variation, capsys: pytest.CaptureFixture[str]
) -> None:
    command = recipe.command
    if not command.startswith("seoro exec"):
        command = f"seoro exec scenarios/cookbook/{recipe.file.name} --clock virtual"
    assert run(f"{command} --seed 0 {variation.options}") == variation.status
    captured = capsys.readouterr()
    assert variation.reason in captured.out + captured.err


def test_all_but_random_draws_have_a_way_to_fail() -> None:
    assert [recipe.file.stem for recipe in RECIPES if not recipe.variations] == ["random_but_repeatable"]


def test_a_campaign_runs_each_value(capsys: pytest.CaptureFixture[str]) -> None:
    [command] = [recipe.command for recipe in RECIPES if recipe.command.startswith("seoro campaign")]
    assert run(command) == 0
    assert "3 runs: 3 passed" in capsys.readouterr().out


def test_draws_follow_from_the_seed() -> None:
    scenario = seoro.load(FOLDER / "random_but_repeatable.osc")
    draws = [seoro.run(scenario, seed=seed, clock="virtual").duration for seed in (1, 1, 2)]
    assert draws[0] == draws[1] != draws[2]
