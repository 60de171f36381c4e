"""Hover texts."""

from pathlib import Path

import pytest

from seoro.lsp.hover import hover
from tests.lsp.helpers import SCENARIO, analysis, split


def shown(folder: Path, marked: str) -> str:
    text, offset = split(marked)
    found = hover(analysis(folder, text), offset)
    return found[0] if found is not None else ""


@pytest.mark.parametrize(
    ("place", "texts"),
    [
        ("li|mit: speed", ["limit: speed = 60kph", "parameter of scenario `main`: `speed` [m/s]", "How fast."]),
        ("limit: sp|eed", ["type speed is SI(m: 1, s: -1)", "physical type, in m/s", "from `osc.types`"]),
        ("60k|ph", ["60kph = 16.67 m/s", "unit of `speed`: 1 kph = 0.277778 m/s"]),
        ("crate: b|ox", ["struct box:\n    weight: mass = 3kg\n    paint: color = red", "A box.\nIt is heavy."]),
        ("paint: color = r|ed", ["color!red = 0", "member of `color`"]),
        ("paint: co|lor", ["enum color: [red, green]", "enumeration"]),
        ("crane.li|ft(", ["action crane.lift:\n    what: box\n    height: length = 1m", "Lifts."]),
        ("crane.lift(wh|at", ["what: box", "parameter of action `crane.lift`: `box`"]),
        ("robot: differential_drive|_robot", ["actor differential_drive_robot", "from `osc.ros`"]),
        ("emit g|o", ["event go(count: int)", "event of scenario `main`"]),
        ("wait @g|o", ["event go(count: int)"]),
        ("occurred.cou|nt", ["count: int", "parameter: `int`"]),
        ("@fi|rst", ["first: serial", "label"]),
        ("def ti|mes", ["def times(count: int, of: mass = 1kg) -> float", "method of struct `box`"]),
        ("expression co|unt", ["count: int", "parameter: `int`"]),
        ("import osc.r|os", ["import osc.ros", "library at `"]),
    ],
)
def test_declarations_are_shown_with_kind_type_and_comment(tmp_path: Path, place: str, texts: list[str]) -> None:
    found = shown(tmp_path, SCENARIO.replace(place.replace("|", ""), place, 1))
    for text in texts:
        assert text in found


def test_temperatures_are_shown_in_kelvin(tmp_path: Path) -> None:
    assert "20C = 293.1 K" in shown(tmp_path, "import osc.types\nglobal t: temperature = 2|0C\n")


def test_names_in_a_text_with_errors_have_hovers(tmp_path: Path) -> None:
    text = SCENARIO.replace("emit go(count: 3)", "emit (((").replace("li|mit", "limit")
    assert "speed" in shown(tmp_path, text.replace("    limit:", "    li|mit:"))


def test_places_between_names_have_no_hover(tmp_path: Path) -> None:
    assert shown(tmp_path, "struct a\n|\nstruct b\n") == ""
