"""The catalogue matches its comments and its page; its scenarios test their ends themselves."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from seoro.embed.directives import Directives, read_directives
from seoro.lang.source import SourceFile

PROJECT = Path(__file__).parents[2]
FILES = sorted((PROJECT / "scenarios" / "catalogue").glob("*.osc"))
PAGE = (PROJECT / "docs" / "reference" / "scenarios.md").read_text()


def directives(file: Path) -> Directives:
    return read_directives(SourceFile(file.name, file.read_text(), file), frozenset()).common


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_catalogue_scenario_states_topic_simulators_and_end(file: Path) -> None:
    found = directives(file)
    opening = file.read_text().split("# seoro:", maxsplit=1)[0].replace("\n# ", " ")
    assert ("Expected to fail" if found.expect == "failed" else "Passes") in opening
    assert found.expect == "passed" or found.reason, "it has to fail for the right reason"
    assert found.simulators == ("mujoco", "pybullet")
    link = rf"\[`{file.stem}`\]\(../../scenarios/catalogue/{file.name}\)"
    assert found.world is not None
    world = found.world.removeprefix(f"{file.parent}/")
    row = rf"\| {link} \| `{world}` \| .* \| {found.expect} \|"
    assert re.search(row, PAGE), f"docs/reference/scenarios.md has no row like: {row}"


def test_the_page_lists_exactly_the_catalogue() -> None:
    assert sorted(re.findall(r"scenarios/catalogue/(\w+)\.osc\)", PAGE)) == [file.stem for file in FILES]
