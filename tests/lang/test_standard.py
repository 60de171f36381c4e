"""Own programs for the examples of the standard: `tests/data/standard` has a folder for each chapter.

A file `name.osc` is valid. In `name.invalid.osc`, exactly the lines that end with `# error` are invalid.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from seoro.lang import frontend, parse_table
from seoro.lang.diagnostic import Bag
from seoro.lang.format.formatter import format_text
from seoro.lang.lexer import Lexer
from seoro.lang.parser import _Parser
from seoro.lang.source import SourceFile
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import NoSolution

FOLDER = Path(__file__).parents[1] / "data" / "standard"
FILES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.osc"))
INVALID = [name for name in FILES if name.endswith(".invalid.osc")]
VALID = [name for name in FILES if name not in INVALID]
UNFORMATTED = "language_syntax/lines.osc"  # contains other valid layouts
SEED = 0


@pytest.mark.parametrize("name", VALID)
def test_valid_examples_of_the_standard_have_no_messages(name: str) -> None:
    assert _check(name).diagnostics == ()


@pytest.mark.parametrize("name", VALID)
def test_valid_examples_of_the_standard_have_a_plan_and_values(name: str) -> None:
    checked = _check(name)
    is_computed_elsewhere = "external" in _text(name)
    for scenario in _scenarios(checked):
        plan = frontend.lower(checked, scenario)
        assert plan.entry == scenario
        if not is_computed_elsewhere:
            assert "duration" in entry_parameters(plan, SEED)


@pytest.mark.parametrize("name", INVALID)
def test_exactly_the_marked_lines_of_invalid_examples_have_messages(name: str) -> None:
    checked = _check(name)
    lines = {found.primary.span.line for found in checked.diagnostics}
    for scenario in _scenarios(checked) if not lines else ():
        try:
            entry_parameters(frontend.lower(checked, scenario), SEED)
        except NoSolution as conflict:
            lines |= {span.line for span, _ in conflict.places}
    marked = {number for number, line in enumerate(_text(name).splitlines(), 1) if line.endswith("# error")}
    assert lines == marked


@pytest.mark.parametrize("name", [name for name in VALID if name != UNFORMATTED])
def test_examples_of_the_standard_are_formatted(name: str) -> None:
    text = _text(name)
    assert format_text(SourceFile(name, text)) == text


def test_examples_of_the_standard_use_every_alternative_of_the_grammar() -> None:
    reduced: set[int] = set()
    for name in FILES:
        reduced |= _reductions(SourceFile(name, _text(name)))
    rules = parse_table.load()["rules"]
    missing = [rule for number, rule in enumerate(rules) if number not in reduced and rule[0] != "lone_expression"]
    assert missing == []


def _reductions(file: SourceFile) -> set[int]:
    """Return the numbers of the rules that the parser reduces by."""
    bag = Bag()
    parser = _Recording(file, bag)
    parser.parse("osc_file", Lexer(file, bag).tokens())
    return parser.reduced


class _Recording(_Parser):
    """Parser that records its reductions, without the shortcut for unit rules."""

    def __init__(self, file: SourceFile, bag: Bag) -> None:
        super().__init__(file, bag)
        self._units = [None] * len(self._units)
        self.reduced: set[int] = set()

    def _reduce(self, number: int) -> Any:
        self.reduced.add(number)
        super()._reduce(number)


def _text(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def _check(name: str) -> frontend.Checked:
    return frontend.check(frontend.load(FOLDER / name, name), strict=True)


def _scenarios(checked: frontend.Checked) -> list[str]:
    """Return the runnable scenarios: `main` if it exists, otherwise those without an actor."""
    return ["main"] if "main" in checked.scenarios else [name for name in checked.scenarios if "." not in name]
