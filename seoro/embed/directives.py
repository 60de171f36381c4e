"""Directives: comments in a scenario file that control how its scenarios are run and tested.

    # seoro: world workshop.yaml
    # seoro: parametrize speed=[1mps, 2mps]
    # pytest: slow, flaky(reruns=2)

Directives directly above a scenario apply to that scenario. Those at the top of the file, followed by an empty
line, apply to all its scenarios. A comment that begins like a directive, and is not valid, is an error.
`seoro exec`, campaigns, clients of executors, embedding programs and pytest read them here.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.errors import UsageError
from seoro.files.world_names import WORLD_FILES, WorldName
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile, Span

if TYPE_CHECKING:
    from seoro.embed.runnable import Runnable
    from seoro.lang.frontend import Checked
    from seoro.lang.symbols import TypeSymbol

INVALID = "invalid"
STATUSES = ("passed", "failed", "error", INVALID)
MAX_VARIANTS = 1000  # of one scenario

_DIRECTIVE = re.compile(r"[ \t]*#[ \t]*(seoro|pytest)[ \t]*:[ \t]*(.*?)[ \t]*")
_AXIS = re.compile(r"\s*([\w.]+)\s*=\s*\[")
_PATH = re.compile(r"[^\s=]+")
_BRACKETS = {"(": ")", "[": "]"}


class Axis(Value):
    """Values of a varied parameter.

    Args:
        name: Path of the parameter.
        values: Expressions of the language.
    """

    name: str
    values: tuple[str, ...]


class MarkComment(Value):
    """A `# pytest:` comment, which the pytest plugin reads.

    Args:
        span: Place of the comment.
        text: Marks in Python syntax.
    """

    span: Span
    text: str


class Directives(Value):
    """The directives of one scenario.

    Args:
        expect: Expected status: `passed`, `failed`, `error`, or `invalid` if it cannot be run.
        reason: Expected part of the reason; may be empty.
        overrides: Values of parameters: pairs of a path and an expression.
        constraints: Constraints on parameters, as boolean expressions.
        axes: Parameters that tests vary, in all combinations.
        files: Parameter files; one test each.
        seeds: Seeds; one test each. Runners of a single run use the first.
        simulators: Names of simulators; one test each. Runners of a single run use the first.
        world: Name or path of the simulator's world; None for the simulator's default.
        timeout: Limit of wall time [s]; None for the runner's default.
        marks: Comments with marks of pytest.
        requirements: Names of requirements that the scenario covers.
    """

    expect: str = "passed"
    reason: str = ""
    overrides: tuple[tuple[str, str], ...] = ()
    constraints: tuple[str, ...] = ()
    axes: tuple[Axis, ...] = ()
    files: tuple[Path, ...] = ()
    seeds: tuple[int, ...] = ()
    simulators: tuple[str, ...] = ()
    world: str | None = None
    timeout: float | None = None
    marks: tuple[MarkComment, ...] = ()
    requirements: tuple[str, ...] = ()


class FileDirectives(Value):
    """The directives of a file.

    Args:
        common: Directives of the file; they apply to every scenario without own ones.
        scenarios: Merged directives of scenarios with own ones, by the line that names the scenario.
    """

    common: Directives
    scenarios: Mapping[int, Directives]


def read_directives(file: SourceFile, scenario_lines: frozenset[int]) -> FileDirectives:
    """Read the directives of a file.

    Args:
        file: The scenario file.
        scenario_lines: The lines, from 1, that name its scenarios.

    Raises:
        UsageError: A directive is invalid or misplaced; the error has its place.
    """
    common = Directives()
    scenarios: dict[int, Directives] = {}
    for number, span, kind, text in directive_comments(file):
        below = _line_below(file, number)
        if below in scenario_lines:
            scenarios[below] = _read(scenarios.get(below, common), span, kind, text)
        elif _is_head(file, number):
            common = _read(common, span, kind, text)
        else:
            raise UsageError(
                f"misplaced directive: expected directly above a scenario or at the top of {file.name}", span
            )
    return FileDirectives(common, scenarios)


def top_scenarios(checked: Checked) -> list[TypeSymbol]:
    """Return the scenarios that the file itself declares, except those of actors, in source order."""
    file = checked.sources.entry.file
    symbols = checked.program.behaviors.values()
    own = [symbol for symbol in symbols if symbol.span.file is file and symbol.plan_name in checked.scenarios]
    return sorted((symbol for symbol in own if symbol.actor is None), key=lambda symbol: symbol.span.start)


def directive_comments(file: SourceFile) -> Iterator[tuple[int, Span, str, str]]:
    """Yield the line (from 1), place, kind (`seoro` or `pytest`) and text of each directive of a file."""
    for number in range(1, file.line_count + 1):
        line = file.line(number)
        if found := _DIRECTIVE.fullmatch(line):
            start = file.start_of_line(number)
            yield number, Span(file, start + line.index("#"), start + len(line.rstrip())), found[1], found[2]


def _line_below(file: SourceFile, number: int) -> int:
    """Return the number of the first line below that is not a comment."""
    while number < file.line_count and file.line(number).lstrip().startswith("#"):
        number += 1
    return number


def _is_head(file: SourceFile, number: int) -> bool:
    """Return whether only comments and empty lines are above a line."""
    lines = (file.line(above).strip() for above in range(1, number))
    return all(not line or line.startswith("#") for line in lines)


def _read(before: Directives, span: Span, kind: str, text: str) -> Directives:
    """Add one directive."""
    if kind == "pytest":
        return replace(before, marks=(*before.marks, MarkComment(span, text)))
    word, _, rest = text.partition(" ")
    reader = _READERS.get(word)
    if reader is None:
        known = ", ".join(_READERS)
        raise UsageError(f"unknown directive `{word}`", span, near(word, _READERS) or f"directives: {known}")
    return reader(before, rest.strip(), span)


# ---------------------------------------------------------------- one function for each directive


def _test(before: Directives, text: str, span: Span) -> Directives:
    if text:
        raise UsageError(f"unexpected `{text}` after `test`", span)
    return before


def _expect(before: Directives, text: str, span: Span) -> Directives:
    status, _, reason = (part.strip() for part in text.partition(":"))
    if status not in STATUSES:
        raise UsageError(f"unknown status `{status}`", span, f"statuses: {', '.join(STATUSES)}")
    return replace(before, expect=status, reason=reason)


def _parametrize(before: Directives, text: str, span: Span) -> Directives:
    axes: list[Axis] = []
    rest = text
    while rest:
        found = _AXIS.match(rest)
        values, end = _items(rest, found.end()) if found else ([], -1)
        if found is None or end < 0 or not all(values):
            raise UsageError(
                f"invalid values of parameters: `{rest}`", span, "for example `speed=[1mps, 2mps] far=[true]`"
            )
        axes.append(Axis(found[1], tuple(values)))
        rest = rest[end:].strip()
    names = [axis.name for axis in (*before.axes, *axes)]
    names += [path for path, _ in before.overrides]
    again = next((name for name in names if names.count(name) > 1), None)
    if again is not None or not axes:
        raise UsageError(f"duplicate parameter `{again}`" if again else "missing parameter", span)
    if math.prod(len(axis.values) for axis in (*before.axes, *axes)) > MAX_VARIANTS:
        raise UsageError(f"too many tests: more than {MAX_VARIANTS}", span)
    return replace(before, axes=(*before.axes, *axes))


def _items(text: str, position: int) -> tuple[list[str], int]:
    """Parse the items of a list from a position; return them and the end position (-1 if unterminated)."""
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
            raise UsageError(
                f"parameter file not found: `{glob}`", span, "paths are relative to the folder of the scenario"
            )
        found += files
    return replace(before, files=(*before.files, *found))


def _requirement(before: Directives, text: str, span: Span) -> Directives:
    names = [name.strip() for name in text.split(",")]
    if not all(names) or any(set(name) & set(" \t") for name in names):
        raise UsageError(
            f"invalid requirements `{text}`: expected names", span, "for example `requirement REQ-12, REQ-13`"
        )
    return replace(before, requirements=tuple(dict.fromkeys((*before.requirements, *names))))


def requirements_of(scenario: Runnable, name: str | None) -> tuple[str, ...]:
    """Return the requirements that a scenario of a file covers.

    Args:
        scenario: The file.
        name: Name of the scenario; None for the entry of the file.

    Raises:
        InvalidScenario, UsageError: A directive is invalid, or the file has no such scenario.
    """
    if "requirement" not in scenario.file.text:  # directives are read once for each run
        return ()
    found = read_directives(scenario.file, scenario.scenario_lines)
    return found.scenarios.get(scenario.entry(name).line, found.common).requirements


def _seed(before: Directives, text: str, span: Span) -> Directives:
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isdecimal() for part in parts):
        raise UsageError(
            f"invalid seed `{text}`: expected whole numbers from 0", span, "for example `seed 1, 2, 3`"
        )
    return replace(before, seeds=tuple(int(part) for part in parts))


def _constrain(before: Directives, text: str, span: Span) -> Directives:
    if not text:
        raise UsageError("missing constraint", span, "for example `constrain pace in [1mps..2mps]`")
    return replace(before, constraints=(*before.constraints, text))


def _set(before: Directives, text: str, span: Span) -> Directives:
    path, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not value or _PATH.fullmatch(path) is None:
        raise UsageError(f"invalid `set {text}`: expected PATH=VALUE", span, "for example `set goal.x=3m`")
    if path in (name for name, _ in before.overrides) or path in (axis.name for axis in before.axes):
        raise UsageError(f"duplicate parameter `{path}`", span)
    return replace(before, overrides=(*before.overrides, (path, value)))


def _simulators(before: Directives, text: str, span: Span) -> Directives:
    from seoro.bridges import launch  # noqa: PLC0415 - Zenoh, for files that name simulators only

    names = tuple(part.strip() for part in text.split(","))
    unknown = next((name for name in names if not launch.is_known(name)), None)
    if unknown is not None:
        known = ", ".join(launch.known_simulators())
        raise UsageError(f"unknown simulator `{unknown}`", span, f"simulators: {known}")
    return replace(before, simulators=names)


def _world(before: Directives, text: str, span: Span) -> Directives:
    if not text:
        raise UsageError("missing world", span, "for example `world maze` or `world worlds/hall.yaml`")
    name = WorldName.parse(text)
    if not name.is_file:
        return replace(before, world=text)
    assert span.file.path is not None
    file = span.file.path.parent / name.world
    if file.is_file():
        return replace(before, world=str(name.replaced(os.fspath(file))))
    if file.suffix in WORLD_FILES:  # others may be names of worlds of ROS 2 systems
        raise UsageError(
            f"world file not found: `{name.world}`", span, "paths are relative to the folder of the scenario"
        )
    return replace(before, world=text)


def _timeout(before: Directives, text: str, span: Span) -> Directives:
    try:
        limit = float(text.removesuffix("s"))
    except ValueError:
        limit = math.nan
    if not (limit > 0 and math.isfinite(limit)):
        raise UsageError(
            f"invalid timeout `{text}`: expected seconds of wall time above 0", span, "for example `timeout 10s`"
        )
    return replace(before, timeout=limit)


_READERS: Mapping[str, Callable[[Directives, str, Span], Directives]] = {
    "constrain": _constrain,
    "expect": _expect,
    "parametrize": _parametrize,
    "params": _params,
    "requirement": _requirement,
    "seed": _seed,
    "set": _set,
    "simulators": _simulators,
    "test": _test,
    "timeout": _timeout,
    "world": _world,
}
