"""Scenarios as the robotics community writes them, with libraries for ROS and simulators: `data/robotics`."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.embed import check_file
from seoro.lang.format.formatter import format_text
from seoro.lang.frontend import lower
from seoro.lang.source import SourceFile
from seoro.runtime.parameters.parameters import entry_parameters

FOLDER = Path(__file__).parents[1] / "data" / "robotics"
FILES = sorted(path.name for path in FOLDER.glob("*.osc"))
SEED = 0


@pytest.mark.parametrize("name", FILES)
def test_scenarios_for_robots_fit_the_libraries(name: str) -> None:
    checked = check_file(FOLDER / name).checked
    assert checked.diagnostics == ()
    entry_parameters(lower(checked), SEED)


@pytest.mark.parametrize("name", FILES)
def test_scenarios_for_robots_are_laid_out_as_the_guide_has_it(name: str) -> None:
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert format_text(SourceFile(name, text)) == text
