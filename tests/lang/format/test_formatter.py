"""The formatter: its results, and that it changes only the layout."""

from __future__ import annotations

import os
import random
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.errors import InvalidScenario
from seoro.lang.format import formatter
from seoro.lang.format.formatter import LayoutFault, format_text
from seoro.lang.source import SourceFile
from tests.lang.format.layouts import dump, shuffle

ROOT = Path(__file__).parents[3]
GOLDENS = sorted((ROOT / "tests/data/format").glob("*.osc"))
OURS = sorted([*(ROOT / "seoro/lang/library").glob("*.osc"), *(ROOT / "scenarios").rglob("*.osc")])
CORPUS = [path.read_text(encoding="utf-8") for path in (*GOLDENS, *OURS)]


def fmt(text: str) -> str:
    return format_text(SourceFile("test.osc", text))


def comments(text: str) -> list[str]:
    """Return the texts of all comments without blanks; no string of the corpus has a `#`."""
    return sorted("".join(found.split()) for found in re.findall(r"#[^\r\n]*", text))


@pytest.mark.parametrize("path", GOLDENS, ids=lambda path: path.stem)
def test_the_layout_equals_the_golden_file(path: Path) -> None:
    text = fmt(path.read_bytes().decode())
    golden = path.with_suffix(".formatted")
    if os.environ.get("SEORO_UPDATE_GOLDENS"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.stem)
def test_bundled_files_are_formatted(path: Path) -> None:
    text = path.read_bytes().decode()
    assert fmt(text) == text, f"run: seoro fmt {path.relative_to(ROOT)}"


@given(st.sampled_from(CORPUS), st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_formatting_changes_the_layout_only_and_is_idempotent(text: str, seed: int) -> None:
    other = shuffle(text, seed)
    tree = dump(text)
    assert dump(other) == tree
    done = fmt(other)
    assert dump(done) == tree
    assert comments(done) == comments(other)
    assert fmt(done) == done


@pytest.mark.slow
def test_formatting_changes_the_layout_only_for_many_layouts() -> None:
    for seed in range(2000):
        text = CORPUS[seed % len(CORPUS)]
        done = fmt(shuffle(text, seed))
        assert dump(done) == dump(text), seed
        assert fmt(done) == done, seed


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("x:int=-3", "x: int = -3"),
        ("x:int=- 3", "x: int = - 3"),  # a negation, not a negative number
        ("x: int = 2-3", "x: int = 2 - 3"),
        ("x: int = a [ 1 ] . b ( c )", "x: int = a[1].b(c)"),
        ("x: int = 3 * - y", "x: int = 3 * -y"),
        ("x: int = not(y)", "x: int = not (y)"),
        ("x: bool = y in[1 .. 2]", "x: bool = y in [1..2]"),
        ("x: kind = kind ! small", "x: kind = kind!small"),
        ("x: int = a?b:c", "x: int = a ? b : c"),
        ("x: int = f(a?b:c,d:e)", "x: int = f(a ? b : c, d: e)"),
        ("x: bool = y . is ( bool )", "x: bool = y.is(bool)"),
        ("keep( default  x )", "keep(default x)"),
        ("keep( default -x )", "keep(default - x)"),  # `default` is a field here
        ("event e is@ f", "event e is @f"),
        ("event e is @f if(x)", "event e is @f if (x)"),
        ("x: a :: b = - 3 |foot/s|", None),
        ("x: a::b = 3|foot/s|", "x: a::b = 3|foot/s|"),
        ("var if: int = is+default", "var if: int = is + default"),
    ],
)
def test_blanks_are_normalised(before: str, after: str | None) -> None:
    text = f"struct s:\n    {before}\n"
    if after is None:
        with pytest.raises(InvalidScenario):
            fmt(text)
    else:
        assert fmt(text) == f"struct s:\n    {after}\n"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", ""),
        ("\n\n  \n", ""),
        ("# only", "# only\n"),
        ("\n\n#a\n\n\n#b\n\n", "# a\n\n# b\n"),
        ("\ufeffstruct a", None),
        ("import osc.a\nimport osc.b\nstruct a", "import osc.a\nimport osc.b\n\nstruct a\n"),
        ("actor a\nactor b", "actor a\nactor b\n"),
        ("actor a\nactor b:\n x: int\nactor c", "actor a\n\nactor b:\n    x: int\n\nactor c\n"),
        ("actor b:\n\n x: int\n\n\n\n y: int", "actor b:\n    x: int\n\n    y: int\n"),
        ("actor b:\n x: int\n# of c\nactor c", "actor b:\n    x: int\n\n# of c\nactor c\n"),
        ("actor b:\n x: int\n # of b\nactor c", "actor b:\n    x: int\n    # of b\n\nactor c\n"),
        ("actor b:\n x: int\n# of b\n\nactor c", "actor b:\n    x: int\n# of b\n\nactor c\n"),
        ("#!x\n##\n#:y\n#\n#z", "#!x\n##\n#:y\n#\n# z\n"),
    ],
)
def test_blank_lines_and_comments_are_normalised(before: str, after: str | None) -> None:
    if after is None:  # a byte order mark belongs to the file, not to its text
        with pytest.raises(InvalidScenario):
            fmt(before)
    else:
        assert fmt(before) == after


def test_strings_and_their_line_ends_are_not_changed() -> None:
    text = 'struct s:\r\n  x: string = """a \r\n  b\t""" +\'c\\\r\nd\'\r\n'
    assert fmt(text) == 'struct s:\n    x: string = """a \r\n  b\t""" + \'c\\\r\nd\'\n'


def test_long_expressions_are_broken_into_lines() -> None:
    draw = random.Random(1)
    names = ["a" * draw.randrange(3, 30) for _ in range(60)]
    expression = "".join(f"{name} {draw.choice(('and', 'or', '+', '*', '=='))} " for name in names) + "last"
    lines = fmt(f"struct s:\n    x: bool = {expression}\n    keep({expression})\n").splitlines()
    assert max(map(len, lines)) <= 100


def test_a_text_with_errors_is_refused() -> None:
    with pytest.raises(InvalidScenario) as caught:
        fmt("struct s:\n    x: int =\n    y: int )\n")
    assert [found.primary.span.line for found in caught.value.diagnostics] == [2, 3]


@pytest.mark.parametrize("change", ["x: int = 3", "x: int = 2 # c", "", "x: int = 2  #\n    x: int = 2"])
def test_a_layout_that_would_change_the_meaning_is_refused(change: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The formatter detects its own defects."""
    monkeypatch.setattr(formatter, "_write", lambda *_: f"struct s:\n    {change}\n")
    with pytest.raises(LayoutFault, match=r"`test.osc` would change its meaning"):
        fmt("struct s:\n    x: int = 2 # comment\n")


def test_brackets_may_be_nested_a_hundred_deep() -> None:
    nested = "(" * 100 + "1" + ")" * 100
    assert nested in fmt(f"struct s:\n    x: int = {nested}\n").replace("\n", "").replace(" ", "")
    with pytest.raises(LayoutFault, match=r"test.osc:2:5: cannot format brackets nested more than 100 deep"):
        fmt(f"struct s:\n    x: int = ({nested})\n")


def test_formatting_time_does_not_double_with_each_bracket() -> None:
    nested = "(1 + " * 40 + "1" + ")" * 40
    assert fmt(f"struct s:\n    x: int = {nested}\n").count("+ (") == 39


@pytest.mark.more
def test_long_lists_are_formatted_in_linear_time() -> None:
    numbers, calls = ", ".join(["1"] * 10_000), " + ".join(["f(1)"] * 2_000)
    assert len(fmt(f"struct s:\n    x: list of int = [{numbers}]\n    y: int = {calls}\n").splitlines()) > 2_000
