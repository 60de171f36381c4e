"""Random texts: token sequences, statements with random expressions, and mutated files."""

from __future__ import annotations

import random
import re
from collections.abc import Mapping
from pathlib import Path

from hypothesis import strategies as st

from seoro.lang import parse_table
from tests.lang.programs import PROGRAMS

ROOT = Path(__file__).parents[2]
MAX_SIZE = 6000  # size limit of mutated files [characters]; longer ones find nothing more

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
VOCABULARY = (*parse_table.load()["literals"], *_NAMES, *_LITERALS, *_LAYOUT)


def soup() -> st.SearchStrategy[str]:
    """Generate any tokens in any order."""
    return st.lists(st.sampled_from((*VOCABULARY, *_ODD)), max_size=80).map(" ".join)


def expressions() -> st.SearchStrategy[str]:
    """Generate expressions by the grammar; their types seldom fit."""
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
    "struct {n} inherits {m}({l} == {e}):\n {l}: {t}\n keep(default {m} == {e})\n keep(it.{l} in {e})",
    "extend {n}:\n {m}: {t} with:\n  keep(it == {e})\n  remove_default(it.{l})\n"
    "  cover({l}, expression: it, every: {e})",
    "extend {n}:\n keep(hard {e})\n remove_default({m})\n var {l}: {t} = sample({e}, @{m}, {e})\n"
    " {n}({e}, {m}: {e})",
    "extend {n}:\n event {m} is @{l} as {n} if {e}\n event {l}({m}: {t}) is rise({e})\n"
    " event {n} is every({e}, offset: {e})",
    "extend {n}:\n cover({m}, expression: {e}, event: {l}, buckets: [{e}, {e}])\n cover(override: {m}, range: {e})"
    "\n record({l}, items: [{m}, {n}], disable: {e}, target: {i})",
    "extend {n}:\n on @{l}.{m} as {n} if {e}:\n  emit {m}({n}: {e})\n  call {n}.{m}({e})\n"
    " on fall({e}):\n  emit {l}",
    "modifier {n}.{m} of {l}:\n keep(it.{l} > {e})\n event {l} is @it.{m}\n on @it.start:\n  emit {l}\n {m}({e})",
    "scenario {n}:\n do {l}: parallel(overlap: {m}, start_to_start: {e}, duration: {e}):\n"
    "  {m}: {n}() with:\n   keep(it.{m} == {e})\n   until {e}\n   {n}({e})\n"
    "  with:\n   override({l}, {m}, {n})\n   until @{m}.{l} if {e}",
)
_TYPES = ("int", "uint", "float", "bool", "string", "length", "time", "part", "colour", "machine", "list of int",
          "list of part", "range of float", "range of a", "a", "ns::a")  # fmt: skip


def statements() -> st.SearchStrategy[str]:
    """Generate files of statements by the grammar."""
    name = st.sampled_from(_NAMES)
    statement = st.tuples(
        st.sampled_from(_STATEMENTS), name, name, name, st.sampled_from(_TYPES), expressions(), st.integers(-3, 9)
    ).map(lambda part: part[0].format(n=part[1], m=part[2], l=part[3], t=part[4], e=part[5], i=part[6]))
    return st.tuples(
        st.sampled_from(("", "import osc.types\n", PROGRAMS[0], PROGRAMS[-1])),
        st.lists(statement, min_size=1, max_size=5),
    ).map(lambda part: part[0] + "\n".join(part[1]) + "\n")


_TYPED: Mapping[str, tuple[str, ...]] = {
    "bool": (
        "true", "p", "q", "s.on", "{int} == {int}", "{int} != {int}", "{int} < {int}", "{float} <= {float}",
        "{int} in [{int}..{int}]", "{float} in r", "{int} in [{int}, {int}, {int}]", "{int} in l", "k == {load}",
        "{load} in [{load}, {load}]", "{length} < {length}", "{length} in [{length}..{length}]", "not ({bool})",
        "({bool} and {bool})", "({bool} or {bool})", "({bool} => {bool})", "({bool} ? {bool} : {bool})",
        "l.size() == {int}", "l.has(it > {int})", "t.has(it.n > {int})", "s.is(odd)", "text == {string}",
        "{part} == {part}", "{part} == {part}", "l == [{int}, {int}]", "r == [{float}..{float}]",
    ),
    "int": (
        "0", "1", "7", "a", "b", "s.n", "l[0]", "t[1].n", "s.twice()", "s.outer(3)", "-{int}", "({int} + {int})",
        "({int} - {int})", "{int} * {int}", "({int} / {int})", "({int} % {int})", "({bool} ? {int} : {int})",
        "l.first_index(it == {int})",
    ),
    "float": (
        "0.5", "1e300", "x", "r.lower()", "r.upper()", "({float} - {float})", "{float} * {float}",
        "({float} / {float})", "{int} * 0.1", "({length} / {length})",
    ),
    "length": (
        "2m", "30cm", "d", "s.w", "({length} + {length})", "{length} * {float}", "({bool} ? {length} : {length})",
    ),
    "load": ("empty", "half", "full", "k", "s.kind", "({bool} ? {load} : {load})"),
    "string": ("'one'", "text", "s.name"),
    "part": ("s", "u", "v", "t[0]", "part(n: {int})", "({bool} ? {part} : {part})"),
}  # fmt: skip
_CHOSEN = """import osc.types
enum load: [empty, half, full]
struct part:
    n: int
    w: length
    on: bool
    kind: load
    name: string = 'part'
    keep(n in [-9..9])
    keep(w in [0m..9m])
    keep({inner})
    def twice() -> int is expression 2 * n
    def outer(a: int) -> int is undefined
struct odd inherits part(kind == half):
    extra: int = 3
    keep({inner})
scenario main:
    a, b: int
    x: float
    p, q: bool
    d: length
    k: load
    l: list of int
    r: range of float
    text: string = {string}
    s, u, v: part
    t: list of part
    keep({bounds})
"""
_BOUNDS = ("a in [0..9]", "b in [-5..5]", "x in [0.0..1.0]", "d in [0m..5m]", "s.w in [1m..2m]", "s.n in [1..3]",
           "r.lower() in [0.0..1.0]", "r.upper() in [2.0..3.0]", "l[0] in [0..9]", "l[1] in [2..3]",
           "t.size() == 2")  # fmt: skip
_INNER = ("n in [0..5]", "w > 1m", "n < 3 => on", "kind == full", "n * n < 10", "default n == 2", "w in [1m..3m]")


def chosen() -> st.SearchStrategy[str]:
    """Generate well-typed scenarios with constraints that may be contradictory."""
    return st.integers(0, 2**48).map(lambda seed: _chosen(random.Random(seed)))


def _chosen(chance: random.Random) -> str:
    bounds = [bound for bound in _BOUNDS if chance.random() < 0.97]
    text = _CHOSEN.format(
        inner=chance.choice(_INNER), string=chance.choice(("'one'", "'two'")), bounds=")\n    keep(".join(bounds)
    )
    for _ in range(chance.randint(1, 6)):
        condition = _typed("bool", chance, chance.randint(1, 4))
        qualifier = chance.choice(("", "", "", "default ", "hard "))
        text += f"    keep({qualifier}({condition}))\n"
        if chance.random() < 0.15:
            text += f"    remove_default({chance.choice(('a', 's.n', 's', 't', 'text'))})\n"
    return text + "    do serial:\n        wait elapsed(1s)\n"


def _typed(type_: str, chance: random.Random, depth: int) -> str:
    """Generate an expression of a type; at depth 0, a leaf."""
    forms = [form for form in _TYPED[type_] if depth > 0 or "{" not in form]
    return re.sub(r"\{(\w+)\}", lambda part: _typed(part[1], chance, depth - 1), chance.choice(forms))


def seeds() -> list[str]:
    """Return files to mutate: programs of the tests, and short scenarios of the project."""
    places = ("scenarios", "seoro/lang/library", "tests/data")
    paths = sorted(path for place in places for path in (ROOT / place).rglob("*.osc"))
    texts = [path.read_bytes().decode("utf-8", "replace") for path in paths]
    return [*PROGRAMS, *(text for text in texts if len(text) <= MAX_SIZE)]


def mutated() -> st.SearchStrategy[str]:
    """Generate a file with up to six mutations; Hypothesis draws only a seed, to be fast."""
    texts = seeds()
    return st.integers(0, 2**48).map(lambda seed: mutate(texts, random.Random(seed)))


def mutate(texts: list[str], chance: random.Random) -> str:
    """Return one of the texts, mutated."""
    text = chance.choice(texts)
    for _ in range(chance.randint(1, 6)):
        text = mutate_once(text, texts, chance)
    return text


def mutate_once(text: str, texts: list[str], chance: random.Random) -> str:
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
