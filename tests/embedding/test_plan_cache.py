"""Cached plans equal new ones, and are used only for unchanged sources."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from seoro.embed import load, plan_cache, prepare
from seoro.embed.options import Options
from seoro.embed.plan_cache import load_cached
from seoro.embed.runnable import Runnable
from seoro.errors import InvalidScenario
from seoro.files.cache import read_cached, write_cached
from tests.plan_outline import outline
from tests.sampling import sampled

ROOT = Path(__file__).parents[2]
TEXT = """import osc.helpers
import osc.types
import "part.osc"

scenario main:
    files: common
    dice: random
    number: int = 3
    do serial:
        log("hello " + files.get_scenario_file_directory())
        log("drawn " + dice.get_random_string(["a", "b", "c"]))
        greet() with:
            retry(count: 2)
        wait elapsed(1s)
"""
PART = 'import osc.helpers\nscenario greet:\n    do log("part")\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "seoro" / "plans"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "part.osc").write_text(PART)
    path = tmp_path / "main.osc"
    path.write_text(TEXT)
    return path


def is_cached(path: Path, name: str | None = None) -> bool:
    """Whether the plan of a scenario is read from the cache."""
    return isinstance(load_cached(path, name), plan_cache._Cached)


def cache_plan(path: Path, name: str | None = None) -> None:
    load_cached(path, name).plan(name, {})


RUNNABLE = sorted(path for part in ("scenarios", "examples") for path in (ROOT / part).rglob("*.osc"))


@pytest.mark.parametrize("path", sampled(RUNNABLE, every=6), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_cached_plan_equals_the_one_that_it_was_made_of(path: Path) -> None:
    scenario = load(path)
    for name in scenario.checked.scenarios:
        try:
            made = scenario.plan(name, {})
            cache_plan(path, name)
        except InvalidScenario:
            continue
        found = load_cached(path, name)
        if isinstance(found, plan_cache._Cached):
            assert outline(found.plan(name, {})) == outline(made)
            assert found.entry(name) == scenario.entry(name)
            assert found.scenario_lines == scenario.scenario_lines
            assert [(each.name, each.text, each.path) for each in found.files] == [
                (each.name, each.text, each.path) for each in scenario.files
            ]


async def messages_of(scenario: Runnable) -> list[str]:
    """Run a scenario; return its log and the values of its parameters."""
    async with prepare(scenario, Options(clock="virtual", seed=7)) as run, run.running():
        logged = [str(record["message"]) async for record in run.trace() if record["kind"] == "log"]
    return [*logged, *run.parameter_texts.values()]


async def test_a_cached_plan_runs_with_its_functions_and_external_methods(file: Path) -> None:
    first = await messages_of(load_cached(file, None))
    assert is_cached(file)
    assert await messages_of(load_cached(file, None)) == first
    assert first[0] == f"hello {file.parent}"


def test_plans_are_cached_for_their_user_only(file: Path, folder: Path) -> None:
    cache_plan(file)
    (plan,) = folder.iterdir()
    assert plan.stat().st_mode & 0o777 == 0o600


def test_each_name_of_a_scenario_has_its_own_plan(file: Path) -> None:
    cache_plan(file, "main")
    assert is_cached(file, "main")
    assert not is_cached(file, "greet")
    with pytest.raises(InvalidScenario):
        load_cached(file, "unknown").entry("unknown")


def test_a_plan_with_overrides_is_not_cached(file: Path) -> None:
    load_cached(file, None).plan(None, {"number": "3"})
    assert not is_cached(file)


CHANGES: dict[str, Callable[[Path], object]] = {
    "the text": lambda path: path.write_text(TEXT.replace("hello", "bye")),
    "an imported text": lambda path: path.with_name("part.osc").write_text(PART.replace("part", "whole")),
    "a library": lambda path: (path.parent / "seoro.libraries").mkdir(),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_plan_is_made_anew_when_something_has_changed(change: str, file: Path) -> None:
    cache_plan(file)
    assert is_cached(file)
    CHANGES[change](file)
    assert not is_cached(file)


def test_another_version_of_seoro_ignores_the_plan(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache_plan(file)
    monkeypatch.setattr(plan_cache, "_makers", lambda: "another")
    assert not is_cached(file)


def test_errors_are_found_again(file: Path) -> None:
    cache_plan(file)
    file.with_name("part.osc").unlink()
    with pytest.raises(InvalidScenario):
        load_cached(file, None)


def test_a_link_that_leads_elsewhere_counts_as_a_change(file: Path) -> None:
    part = file.with_name("part.osc")
    cache_plan(file)
    part.rename(file.with_name("other.osc"))
    part.symlink_to("other.osc")
    assert not is_cached(file)


def test_scenarios_with_libraries_beside_them_are_not_cached(file: Path) -> None:
    library = file.parent / "seoro.libraries" / "mine.osc"
    library.parent.mkdir()
    library.write_text("struct mine:\n    a: int\n")
    file.write_text("import osc.mine\n" + TEXT)
    cache_plan(file)
    assert not is_cached(file)


def test_scenarios_with_functions_beside_them_are_not_cached(file: Path) -> None:
    file.with_name("mine.py").write_text("def one() -> int:\n    return 1\n")
    file.write_text(TEXT + "struct mine:\n    def one() -> int is external mine.one()\n")
    cache_plan(file)
    assert not is_cached(file)


def changed(content: bytes, change: Callable[[Any, Any], object]) -> bytes:
    """A cached plan with changes in its sources or its table."""
    head, table = map(json.loads, content.decode().split("\n"))
    change(head, table)
    return f"{json.dumps(head)}\n{json.dumps(table)}".encode()


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "cut off": lambda content: content[:-20],
    "no plan": lambda content: content[: content.index(b"\n") + 1],
    "another class": lambda content: changed(content, lambda _, table: table[-1].__setitem__(0, 10_000)),
    "other data": lambda content: changed(content, lambda _, table: table.append([2])),
    "other sources": lambda content: changed(content, lambda head, _: head.pop()),
    "not text": lambda _: b"\xff\n\xff",
    "deep data": lambda content: content[: content.index(b"\n") + 1] + b"[" * 100_000,
    "pickled data": lambda _: b"\x80\x04K\x01.",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_plans_are_made_anew_and_replaced(damage: str, file: Path, folder: Path) -> None:
    cache_plan(file)
    (place,) = folder.iterdir()
    content = read_cached(place)
    assert content is not None
    write_cached(place, DAMAGES[damage](content))
    assert not is_cached(file)
    cache_plan(file)
    assert is_cached(file)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("seoro.actions.messages", "os"),
        ("seoro.actions.helpers.get_scenario_file_directory", "os.getcwd"),
        ("seoro.actions.helpers.get_scenario_file_directory", "seoro.actions.helpers.get_output_directory"),
    ],
)
def test_only_functions_that_the_libraries_name_are_bound(
    before: str, after: str, file: Path, folder: Path
) -> None:
    cache_plan(file)
    (place,) = folder.iterdir()
    content = read_cached(place)
    assert content is not None
    assert before.encode() in content
    write_cached(place, content.replace(before.encode(), after.encode()))
    assert not is_cached(file)


@pytest.mark.parametrize("mode", [0o622, 0o620, 0o602])
def test_a_plan_that_others_may_write_is_not_read(mode: int, file: Path, folder: Path) -> None:
    cache_plan(file)
    (place,) = folder.iterdir()
    place.chmod(mode)
    assert not is_cached(file)
    cache_plan(file)
    assert is_cached(file)


@pytest.mark.parametrize("mode", [0o720, 0o702, 0o777])
def test_a_plan_in_a_folder_that_others_may_write_is_not_read(mode: int, file: Path, folder: Path) -> None:
    cache_plan(file)
    folder.chmod(mode)
    assert not is_cached(file)


def test_a_plan_of_a_different_user_is_ignored(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache_plan(file)
    user = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: user + 1)
    assert not is_cached(file)


def test_deep_plans_are_cached(tmp_path: Path) -> None:
    path = tmp_path / "deep.osc"
    sum_ = " + ".join(["1"] * 3000)
    path.write_text(f"import osc.types\nscenario main:\n    a: int = {sum_}\n    do wait elapsed(1s)\n")
    cache_plan(path)
    assert is_cached(path)


def test_the_oldest_plans_are_removed(file: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_cache, "MAX_PLANS", 2)
    for number in range(4):
        path = file.with_name(f"main{number}.osc")
        path.write_text(TEXT)
        cache_plan(path)
    assert len(list(folder.iterdir())) == 2


def test_an_unusable_cache_folder_is_ignored(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "in the way").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "in the way"))
    cache_plan(file)
    assert not is_cached(file)
