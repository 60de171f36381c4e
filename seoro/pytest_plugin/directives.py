"""What comments of a scenario file tell pytest.

    # seoro: expect failed: did not arrive
    # seoro: parametrize speed=[1mps, 2mps]
    # pytest: slow, flaky(reruns=2)

Comments directly above a scenario are for that scenario, those at the top of the file, with an empty line after
them, for all of its tests. A comment that begins like these and is none of them is an error.
"""

from __future__ import annotations

import ast
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.launch import known_simulators
from seoro.errors import InvalidUse
from seoro.lang.diagnostics import near
from seoro.lang.source import SourceFile, Span

INVALID = "invalid"
STATUSES = ("passed", "failed", "error", INVALID)
MAX_VARIANTS = 1000  # of one scenario

_DIRECTIVE = re.compile(r"[ \t]*#[ \t]*(seoro|pytest)[ \t]*:[ \t]*(.*?)[ \t]*")
_AXIS = re.compile(r"\s*([\w.]+)\s*=\s*\[")
_BRACKETS = {"(": ")", "[": "]"}


@dataclass(frozen=True)
class Axis:
    """Values that a parameter takes one after another.

    Args:
        name: Path of the parameter.
        values: Expressions of the language.
    """

    name: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class Directives:
    """What the comments say of a test.

    Args:
        expect: How the run has to end: `passed`, `failed`, `error`, or `invalid` if it cannot be run.
        reason: What stands in the reason then; may be empty.
        axes: Parameters that are varied, each with each.
        files: Parameter files, each of which makes a test.
        seeds: Each makes a test; empty for the one that pytest was given.
        simulators: Each makes a test; empty for the one that pytest or the folder chooses.
        world: Name or path of the simulator's world; None for the one that goes with the simulator.
        timeout: Limit of wall time [s].
        marks: Marks of pytest.
    """

    expect: str = "passed"
    reason: str = ""
    axes: tuple[Axis, ...] = ()
    files: tuple[Path, ...] = ()
    seeds: tuple[int, ...] = ()
    simulators: tuple[str, ...] = ()
    world: str | None = None
    timeout: float | None = None
    marks: tuple[pytest.MarkDecorator, ...] = ()


@dataclass(frozen=True)
class FileDirectives:
    """What the comments of a file say.

    Args:
        common: Of all of its tests.
        scenarios: Of scenarios that have comments of their own, by the line that names them; with the common.
    """

    common: Directives
    scenarios: Mapping[int, Directives]


def read_directives(file: SourceFile, scenario_lines: frozenset[int]) -> FileDirectives:
    """Read the comments of a file.

    Args:
        file: The scenario file.
        scenario_lines: The lines, from 1, in which its scenarios are named.

    Raises:
        InvalidUse: A comment says what cannot be, or stands where it is for nothing.
    """
    common = Directives()
    own: dict[int, list[tuple[Span, str, str]]] = {}
    for number, span, kind, text in _comments(file):
        below = _line_below(file, number)
        if below in scenario_lines:
            own.setdefault(below, []).append((span, kind, text))
        elif _is_head(file, number):
            common = _read(common, span, kind, text)
        else:
            raise InvalidUse(
                f"this is for no test: it stands neither directly above a scenario nor at the top of {file.name}",
                span,
            )
    scenarios = {}
    for line, comments in own.items():
        found = common
        for span, kind, text in comments:
            found = _read(found, span, kind, text)
        scenarios[line] = found
    return FileDirectives(common, scenarios)


def _comments(file: SourceFile) -> Iterator[tuple[int, Span, str, str]]:
    for number in range(1, file.line_count + 1):
        line = file.line(number)
        if found := _DIRECTIVE.fullmatch(line):
            start = file.start_of_line(number)
            yield number, Span(file, start + line.index("#"), start + len(line.rstrip())), found[1], found[2]


def _line_below(file: SourceFile, number: int) -> int:
    """The first line below that is no comment."""
    while number < file.line_count and file.line(number).lstrip().startswith("#"):
        number += 1
    return number


def _is_head(file: SourceFile, number: int) -> bool:
    """Whether only comments and empty lines stand above a line."""
    lines = (file.line(above).strip() for above in range(1, number))
    return all(not line or line.startswith("#") for line in lines)


def _read(before: Directives, span: Span, kind: str, text: str) -> Directives:
    """Add what one comment says."""
    if kind == "pytest":
        return replace(before, marks=(*before.marks, *_marks(text, span)))
    word, _, rest = text.partition(" ")
    reader = _READERS.get(word)
    if reader is None:
        known = ", ".join(_READERS)
        raise InvalidUse(f"there is no `{word}` here", span, near(word, _READERS) or f"there are {known}")
    return reader(before, rest.strip(), span)


# ---------------------------------------------------------------- one function for each word


def _test(before: Directives, text: str, span: Span) -> Directives:
    if text:
        raise InvalidUse("nothing stands behind `test`", span)
    return before


def _expect(before: Directives, text: str, span: Span) -> Directives:
    status, _, reason = (part.strip() for part in text.partition(":"))
    if status not in STATUSES:
        raise InvalidUse(f"a run does not end `{status}`", span, f"it ends {', '.join(STATUSES)}")
    return replace(before, expect=status, reason=reason)


def _parametrize(before: Directives, text: str, span: Span) -> Directives:
    axes: list[Axis] = []
    rest = text
    while rest:
        found = _AXIS.match(rest)
        values, end = _items(rest, found.end()) if found else ([], -1)
        if found is None or end < 0 or not all(values):
            raise InvalidUse(
                "values of parameters look otherwise", span, "such as `speed=[1mps, 2mps] far=[true]`"
            )
        axes.append(Axis(found[1], tuple(values)))
        rest = rest[end:].strip()
    names = [axis.name for axis in (*before.axes, *axes)]
    again = next((name for name in names if names.count(name) > 1), None)
    if again is not None or not axes:
        raise InvalidUse(f"`{again}` is varied twice" if again else "no parameter is named here", span)
    if math.prod(len(axis.values) for axis in (*before.axes, *axes)) > MAX_VARIANTS:
        raise InvalidUse(f"this makes more than {MAX_VARIANTS} tests", span)
    return replace(before, axes=(*before.axes, *axes))


def _items(text: str, position: int) -> tuple[list[str], int]:
    """The items of a list, which begin at a position, and where the text goes on; -1 if the list does not end."""
    items, start, expected, quote = [], position, ["]"], ""
    while position < len(text):
        char = text[position]
        if quote:
            if char == "\\":
                position += 1
            elif char == quote:
                quote = ""
        elif char in "\"'":
            quote = char
        elif char in _BRACKETS:
            expected.append(_BRACKETS[char])
        elif char == expected[-1]:
            expected.pop()
        if not quote and (not expected or (char == "," and len(expected) == 1)):
            items.append(text[start:position].strip())
            start = position + 1
        position += 1
        if not expected:
            return items, position
    return [], -1


def _params(before: Directives, text: str, span: Span) -> Directives:
    assert span.file.path is not None
    found: list[Path] = []
    for glob in (part.strip() for part in text.split(",")):
        files = sorted(span.file.path.parent.glob(glob)) if glob and not Path(glob).is_absolute() else []
        if not files:
            raise InvalidUse(
                f"there is no parameter file `{glob}`", span, "files are named from the scenario's folder"
            )
        found += files
    return replace(before, files=(*before.files, *found))


def _seed(before: Directives, text: str, span: Span) -> Directives:
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdecimal() for part in parts):
        raise InvalidUse("seeds are whole numbers from 0", span, "such as `seed 1, 2, 3`")
    return replace(before, seeds=tuple(int(part) for part in parts))


def _simulators(before: Directives, text: str, span: Span) -> Directives:
    names = tuple(part.strip() for part in text.split(","))
    known = known_simulators()
    unknown = next((name for name in names if name not in known), None)
    if unknown is not None:
        raise InvalidUse(f"there is no simulator `{unknown}`", span, f"there are {', '.join(known)}")
    return replace(before, simulators=names)


def _world(before: Directives, text: str, span: Span) -> Directives:
    if not text:
        raise InvalidUse("no world is named here", span, "such as `world maze`, or `world worlds/hall.yaml`")
    if not text.endswith(".yaml"):
        return replace(before, world=text)
    assert span.file.path is not None
    file = span.file.path.parent / text
    if not file.is_file():
        raise InvalidUse(f"there is no world file `{text}`", span, "files are named from the scenario's folder")
    return replace(before, world=os.fspath(file))


def _timeout(before: Directives, text: str, span: Span) -> Directives:
    try:
        limit = float(text.removesuffix("s"))
    except ValueError:
        limit = math.nan
    if not (limit > 0 and math.isfinite(limit)):
        raise InvalidUse("a limit of wall time is a number of seconds above 0", span, "such as `timeout 10s`")
    return replace(before, timeout=limit)


_READERS: Mapping[str, Callable[[Directives, str, Span], Directives]] = {
    "expect": _expect,
    "parametrize": _parametrize,
    "params": _params,
    "seed": _seed,
    "simulators": _simulators,
    "test": _test,
    "timeout": _timeout,
    "world": _world,
}


# ---------------------------------------------------------------- marks


def _marks(text: str, span: Span) -> Iterator[pytest.MarkDecorator]:
    try:
        tree = ast.parse(f"[{text}]", mode="eval").body
        assert isinstance(tree, ast.List)
        parsed = [_mark(element) for element in tree.elts]
    except (SyntaxError, ValueError) as error:
        raise InvalidUse("these are no marks", span, "such as `slow, flaky(reruns=2)`") from error
    if not parsed:
        raise InvalidUse("no mark is named here", span, "such as `slow, flaky(reruns=2)`")
    for name, arguments, keywords in parsed:
        if name == "parametrize":
            raise InvalidUse(
                "scenarios are varied otherwise", span, "write `# seoro: parametrize speed=[1mps, 2mps]`"
            )
        try:
            mark: pytest.MarkDecorator = getattr(pytest.mark, name)
        except (AttributeError, pytest.fail.Exception) as error:
            raise InvalidUse(str(error), span) from error
        # `with_args`, since a mark that is called with a function alone would decorate it.
        yield mark.with_args(*arguments, **keywords) if arguments or keywords else mark


def _mark(element: ast.expr) -> tuple[str, list[Any], dict[str, Any]]:
    """The name and the arguments, which are literals, of a mark; `ValueError` if it is none."""
    match element:
        case ast.Name(id=name):
            return name, [], {}
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=keywords):
            named = {keyword.arg: ast.literal_eval(keyword.value) for keyword in keywords if keyword.arg}
            return name, [ast.literal_eval(argument) for argument in arguments], named
    raise ValueError
