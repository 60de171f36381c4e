"""The catalogue is what its comments and its page say. That its scenarios end so is tested by themselves."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from seoro.embed.directives import Directives, read_directives
from seoro.lang.source import SourceFile

PROJECT = Path(__file__).parents[2]
FILES = sorted((PROJECT / "scenarios" / "catalogue").glob("*.osc"))
PAGE = (PROJECT / "docs" / "catalogue.md").read_text()


def directives(file: Path) -> Directives:
    return read_directives(SourceFile(file.name, file.read_text(), file), frozenset()).common


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_scenario_says_what_it_shows_where_and_how_it_ends(file: Path) -> None:
    found = directives(file)
    opening = file.read_text().split("# seoro:", maxsplit=1)[0].replace("\n# ", " ")
    assert ("Fails, as it should" if found.expect == "failed" else "Passes") in opening
    assert found.expect == "passed" or found.reason, "it has to fail for the right reason"
    assert found.simulators == ("mujoco", "pybullet")
    link = rf"\[`{file.stem}`\]\(../scenarios/catalogue/{file.name}\)"
    assert found.world is not None
    world = found.world.removeprefix(f"{file.parent}/")
    row = rf"\| {link} \| `{world}` \| .* \| {found.expect} \|"
    assert re.search(row, PAGE), f"docs/catalogue.md has no row like: {row}"


def test_the_page_has_nothing_else() -> None:
    assert sorted(re.findall(r"scenarios/catalogue/(\w+)\.osc\)", PAGE)) == [file.stem for file in FILES]
