"""What the standard shows, in programs of our own: `tests/data/standard` has a folder for each of its chapters.

A file `name.osc` is right by the standard. In `name.invalid.osc` the lines that end with `# error` are wrong, and
no others.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from seoro.lang import frontend, table
from seoro.lang.diagnostic import Bag
from seoro.lang.format.formatter import format_text
from seoro.lang.lexer import Lexer
from seoro.lang.parser import _Parser
from seoro.lang.source import SourceFile
from seoro.runtime.environment import NoChoice
from seoro.runtime.instantiate import entry_parameters

FOLDER = Path(__file__).parents[1] / "data" / "standard"
FILES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.osc"))
INVALID = [name for name in FILES if name.endswith(".invalid.osc")]
VALID = [name for name in FILES if name not in INVALID]
UNFORMATTED = "language_syntax/lines.osc"  # shows what else is allowed
SEED = 0


@pytest.mark.parametrize("name", VALID)
def test_what_is_right_by_the_standard_has_no_messages(name: str) -> None:
    assert _check(name).diagnostics == ()


@pytest.mark.parametrize("name", VALID)
def test_what_is_right_by_the_standard_has_a_plan_and_values(name: str) -> None:
    checked = _check(name)
    is_computed_elsewhere = "external" in _text(name)
    for scenario in _scenarios(checked):
        plan = frontend.lower(checked, scenario)
        if not is_computed_elsewhere:
            entry_parameters(plan, SEED)


@pytest.mark.parametrize("name", INVALID)
def test_exactly_what_is_wrong_by_the_standard_has_messages(name: str) -> None:
    checked = _check(name)
    lines = {found.primary.span.line for found in checked.diagnostics}
    for scenario in _scenarios(checked) if not lines else ():
        try:
            entry_parameters(frontend.lower(checked, scenario), SEED)
        except NoChoice as conflict:
            lines |= {span.line for span, _ in conflict.places}
    marked = {number for number, line in enumerate(_text(name).splitlines(), 1) if line.endswith("# error")}
    assert lines == marked


@pytest.mark.parametrize("name", [name for name in VALID if name != UNFORMATTED])
def test_all_are_laid_out_as_the_guide_has_it(name: str) -> None:
    text = _text(name)
    assert format_text(SourceFile(name, text)) == text


def test_every_alternative_of_the_grammar_occurs() -> None:
    reduced: set[int] = set()
    for name in FILES:
        reduced |= _reductions(SourceFile(name, _text(name)))
    rules = table.load()["rules"]
    missing = [rule for number, rule in enumerate(rules) if number not in reduced and rule[0] != "lone_expression"]
    assert missing == []


def _reductions(file: SourceFile) -> set[int]:
    """The numbers of the rules that the parser reduces by."""
    bag = Bag()
    parser = _Recording(file, bag)
    parser.parse("osc_file", Lexer(file, bag).tokens())
    return parser.reduced


class _Recording(_Parser):
    """Notes what it reduces by; without the shortcut for rules of one thing."""

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
    """The scenarios that can be run: `main` if there is one, otherwise those of no actor."""
    return ["main"] if "main" in checked.scenarios else [name for name in checked.scenarios if "." not in name]
