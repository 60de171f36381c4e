"""Reference pages contain what the code declares."""

import re
from pathlib import Path

import pytest

from seoro.cli.commands import COMMANDS
from seoro.lang.explain import codes
from tests.tools.reference import GENERATORS, PLACEHOLDER, insert

PAGES = sorted((Path(__file__).parents[2] / "docs").rglob("*.md"))


def test_every_placeholder_has_a_generator_and_every_generator_a_page() -> None:
    named = [name for page in PAGES for name in PLACEHOLDER.findall(page.read_text())]
    assert sorted(named) == sorted(GENERATORS)


@pytest.mark.parametrize("name", GENERATORS)
def test_a_generator_makes_a_table_without_empty_meanings_of_all_rows(name: str) -> None:
    text = insert(f"<!-- generated: {name} -->")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(rows) > 3
    assert "<!--" not in text


def test_the_command_page_has_all_commands_and_options() -> None:
    text = GENERATORS["commands"]()
    assert re.findall(r"^## seoro ([\w-]+)$", text, re.MULTILINE) == list(COMMANDS)
    assert "| `--seed` `N` |" in text


def test_the_code_page_has_all_codes() -> None:
    assert re.findall(r"^\| (E\d{4}) \|", GENERATORS["codes"](), re.MULTILINE) == list(codes())


def test_the_library_page_names_parameters_with_their_defaults() -> None:
    text = GENERATORS["libraries"]()
    assert "`differential_drive_robot.drive(linear: speed = 0mps" in text
    assert "## osc.helpers" in text


def test_the_schema_of_lab_files_has_nested_keys_with_their_meaning() -> None:
    text = GENERATORS["lab file"]()
    assert re.search(r"^\| `robots\.NAME\.limits\.speed` \| number, > 0 \|", text, re.MULTILINE)
    assert "| `bridges.NAME.connect` | text | required |" in text


def test_the_protocol_page_has_verbs_with_their_fields() -> None:
    assert re.search(r"^\| `advance` \| .*`horizon`", GENERATORS["node verbs"](), re.MULTILINE)
    assert "| `submit` |" in GENERATORS["executor verbs"]()
