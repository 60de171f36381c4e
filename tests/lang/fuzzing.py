"""Texts that are hardly scenarios: token soup, statements with wild expressions, and files with mutations."""

from __future__ import annotations

import random
from pathlib import Path

from hypothesis import strategies as st

from seoro.lang import table
from tests.lang.programs import PROGRAMS

ROOT = Path(__file__).parents[2]
MAX_SIZE = 6000  # characters of a file that is mutated; longer ones say nothing more

_NAMES = (
    "a",
    "b",
    "main",
    "part",
    "machine",
    "colour",
    "red",
    "size",
    "it",
    "actor",
    "_x",
    "|a b|",
    "ns::a",
    "::a",
    "é",
)
_LITERALS = (
    "0", "1", "7", "18446744073709551616", "0x1F", "1.5", "1e400", ".5", "inf", "nan", "2m", "30kph", "5nounit",
    "-1", "true", "false", '"text"', "'t'", '"""long"""', '"\\n"', '"', "'", '"""', "[1, 2]", "[1..2]",
)  # fmt: skip
_LAYOUT = ("\n", "\n    ", "\n        ", "\n  ", "\n\t", " ", "  ", "\\\n", "# c\n", "\r\n", "\f")
_ODD = (
    "\0",
    "\u2028",
    "\x85",
    "\ufeff",
    "😀",
    "\u0301",
    "\x1b",
    "$",
    "{",
    "}",
    ";",
    "|",
    "`",
    "&",
    "~",
    "^",
    "ß",
    "\U0001d4b3",
)
VOCABULARY = (*table.load()["literals"], *_NAMES, *_LITERALS, *_LAYOUT)


def soup() -> st.SearchStrategy[str]:
    """Any tokens in any order."""
    return st.lists(st.sampled_from((*VOCABULARY, *_ODD)), max_size=80).map(" ".join)


def expressions() -> st.SearchStrategy[str]:
    """Expressions by the grammar; their types seldom fit."""
    leaf = st.sampled_from((*_NAMES, *_LITERALS))
    operators = st.sampled_from(
        ("+", "-", "*", "/", "%", "==", "!=", "<", "<=", ">", ">=", "in", "and", "or", "=>", ".", "..", "!")
    )

    def deeper(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        calls = (
            "size()",
            "filter(it > {})",
            "map({})",
            "as(int)",
            "is(part)",
            "lower()",
            "has({})",
            "area({})",
            "x({})",
        )
        return st.one_of(
            st.tuples(inner, operators, inner).map(" ".join),
            st.tuples(inner, inner, inner).map(lambda each: f"{each[0]} ? {each[1]} : {each[2]}"),
            inner.map(lambda each: f"({each})"),
            inner.map(lambda each: f"not {each}"),
            inner.map(lambda each: f"-{each}"),
            st.lists(inner, min_size=1, max_size=3).map(lambda each: f"[{', '.join(each)}]"),
            st.tuples(inner, inner).map(lambda each: f"{each[0]}[{each[1]}]"),
            st.tuples(inner, st.sampled_from(calls), inner).map(
                lambda each: f"{each[0]}.{each[1].format(each[2])}"
            ),
            st.tuples(st.sampled_from(("part", "f", "pose_3d")), inner).map(
                lambda each: f"{each[0]}(size: {each[1]})"
            ),
        )

    return st.recursive(leaf, deeper, max_leaves=8)


_STATEMENTS = (
    "import osc.{n}",
    "import '{n}'",
    "namespace {n} use {m}",
    "export {n}, {m}::*",
    "global {n}: {t} = {e}",
    "type {n} is SI(m: 1, s: {i})",
    "unit {n} of {t} is SI(m: 1, factor: {i})",
    "enum {n}: [{m}, {m} = {i}]",
    "struct {n} inherits {n}:\n {m}: {t} = {e}",
    "struct {n}:\n {m}: {t} = {e}\n def {m}({m}: {t} = {e}) -> {t} is expression {e}",
    "actor {n}:\n {m}: {t} = {e}",
    "extend {n}:\n {m}: {t}",
    "extend int:\n def {m}() -> {t} is expression {e}",
    "action {n}.{m}:\n {m}: {t} = {e}",
    "modifier {n} of {n}:\n {m}: {t}",
    "scenario {n}:\n {m}: {t} = {e}\n do serial:\n  wait {e}\n  {l}: {n}({e}, {m}: {e})",
    "scenario {n}.{m}:\n event {m}({m}: {t} = {e})\n do parallel:\n  emit {m}({e})\n  wait @{l}.end",
    "scenario {n}:\n do one_of:\n  wait elapsed({e})\n  wait rise({e})\n  {n}.{m}({e})\n  call {e}",
    "scenario {n}:\n var {m}: {t} = {e}\n keep({e})\n cover({e})\n on @{l}:\n  emit {m}\n do {n}()",
)
_TYPES = ("int", "uint", "float", "bool", "string", "length", "time", "part", "colour", "machine", "list of int",
          "list of part", "range of float", "range of a", "a", "ns::a")  # fmt: skip


def statements() -> st.SearchStrategy[str]:
    """Files of statements by the grammar."""
    name = st.sampled_from(_NAMES)
    statement = st.tuples(
        st.sampled_from(_STATEMENTS), name, name, name, st.sampled_from(_TYPES), expressions(), st.integers(-3, 9)
    ).map(lambda part: part[0].format(n=part[1], m=part[2], l=part[3], t=part[4], e=part[5], i=part[6]))
    return st.tuples(
        st.sampled_from(("", "import osc.types\n", PROGRAMS[0])), st.lists(statement, min_size=1, max_size=5)
    ).map(lambda part: part[0] + "\n".join(part[1]) + "\n")


def seeds() -> list[str]:
    """Files to mutate: programs of the tests, and those of the project that are not long."""
    places = ("scenarios", "seoro/lang/library", "tests/data")
    paths = sorted(path for place in places for path in (ROOT / place).rglob("*.osc"))
    texts = [path.read_bytes().decode("utf-8", "replace") for path in paths]
    return [*PROGRAMS, *(text for text in texts if len(text) <= MAX_SIZE)]


def mutated() -> st.SearchStrategy[str]:
    """A file with up to six mutations; Hypothesis draws a number only, as drawing each choice takes its time."""
    texts = seeds()
    return st.integers(0, 2**48).map(lambda seed: mutate(texts, random.Random(seed)))


def mutate(texts: list[str], chance: random.Random) -> str:
    """One of the texts, mutated."""
    text = chance.choice(texts)
    for _ in range(chance.randint(1, 6)):
        text = _mutate_once(text, texts, chance)
    return text


def _mutate_once(text: str, texts: list[str], chance: random.Random) -> str:
    lines = text.splitlines(keepends=True) or [""]
    at, line = chance.randint(0, len(text)), chance.randrange(len(lines))
    match chance.randrange(11):
        case 0:
            return text[:at] + text[at + chance.randint(1, 4) :]
        case 1:
            return text[:at] + chance.choice((*VOCABULARY, *_ODD)) + text[at:]
        case 2:
            return text[:at] + chr(chance.randrange(0x300)) + text[at:]
        case 3:
            del lines[line]
        case 4:
            lines.insert(line, lines[line])
        case 5:
            other = chance.randrange(len(lines))
            lines[line], lines[other] = lines[other], lines[line]
        case 6:
            lines[line] = chance.choice(("", " ", "    ", "\t", "        ")) + lines[line].lstrip(
                chance.choice(("", " \t"))
            )
        case 7:
            return text[:at]
        case 8:
            other_lines = chance.choice(texts).splitlines(keepends=True)
            start = chance.randrange(max(len(other_lines), 1))
            lines[line:line] = other_lines[start : start + chance.randint(1, 12)]
        case 9:
            words = lines[line].split(" ")
            first, second = chance.randrange(len(words)), chance.randrange(len(words))
            words[first], words[second] = words[second], words[first]
            lines[line] = " ".join(words)
        case _:
            words = lines[line].split(" ")
            words[chance.randrange(len(words))] = chance.choice(VOCABULARY)
            lines[line] = " ".join(words)
    return "".join(lines)
