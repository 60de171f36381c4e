"""Generated programs as data, which shrinks well, and their text.

Labels are numbered by place, and references choose a label by any number. So a program stays valid if parts of it
are removed or moved.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

HEADER = """import osc.types
import osc.helpers

action hold
action work:
    seconds: time
action give_up

struct meter:
    event tick is every(1s, offset: 0.5s)
    var ticks: int = sample(ticks + 1, @tick, 0)

modifier patient:
    limit: time
    timeout(limit)
modifier anyhow:
    retry(2)
    inverter()

scenario base:
    event one
    event two
    event sent(level: int)
    event derived is @one if n % 2 == 1
    var n: int = 0
    var seen: int = sample(n, @two, 0)
    def twice(k: int) -> int is expression 2 * k

modifier paced of worker:
    span: time
    keep(it.pace == span)
"""
PARAMETERS: Mapping[str, str] = {
    "inner": "",
    "worker": "    size: int\n    keep(default size == 1)\n    pace: time = 1s\n",
    "main": "    gauge: meter\n",
}


@dataclass(frozen=True)
class Line:
    """A line that may refer to labels of its scenario.

    Args:
        template: With `{any}` and `{other}` for labels of any behavior, `{worker}` for one of an invocation of
            `worker`, and `{number}` for a number of its own.
        pick: Labels of the overridden and the overriding behavior.
        instead: Text if its scenario has no such label; None to omit the line.
    """

    template: str
    pick: int = 0
    instead: str | None = None


@dataclass(frozen=True)
class Statement:
    """A behavior in one line.

    Args:
        line: The line.
        is_labelled: Whether it has a label.
    """

    line: Line
    is_labelled: bool = False


@dataclass(frozen=True)
class Block:
    """A composition, or an invocation with modifiers.

    Args:
        head: Its first line, without a colon.
        members: Members of a composition; empty for an invocation.
        within: Lines of its `with` block.
        is_labelled: Whether it has a label.
    """

    head: str
    members: tuple[Behavior, ...] = ()
    within: tuple[Line, ...] = ()
    is_labelled: bool = False


Behavior: TypeAlias = Statement | Block


@dataclass(frozen=True)
class Scenario:
    """A scenario that inherits `base`.

    Args:
        body: Its body.
        extra: The specification of its event `extra`.
        members: Other members: `on`, variables, modifiers.
    """

    body: Behavior
    extra: Line = field(default_factory=lambda: Line("@one"))
    members: tuple[Line, ...] = ()


@dataclass(frozen=True)
class Program:
    """A file; `main` may invoke `worker` and `inner`, and `worker` may invoke `inner`."""

    inner: Scenario
    worker: Scenario
    main: Scenario

    def text(self, mirrored: bool = False) -> str:
        """Return its text; mirrored, with the members of every `parallel` in reverse order.

        A primary first member stays the first.
        """
        scenarios = {"inner": self.inner, "worker": self.worker, "main": self.main}
        return HEADER + "".join(_scenario(name, scenario, mirrored) for name, scenario in scenarios.items())


def _scenario(name: str, scenario: Scenario, mirrored: bool) -> str:
    text = _Text(tuple(_labels(scenario.body)), mirrored)
    body = "\n".join(text.behavior(scenario.body, 4)).strip()
    lines = [f"scenario {name} inherits base:", *PARAMETERS[name].splitlines()]
    lines += [f"    event extra is {text.line(scenario.extra)}"]
    for member in scenario.members:
        shown = text.line(member)
        lines += [f"    {part}" for part in (shown or "").splitlines()]
    return "\n".join([*lines, f"    do {body}", ""])


def _labels(behavior: Behavior) -> Iterator[bool]:
    """Yield for each labelled behavior, in source order, whether it invokes `worker`."""
    if behavior.is_labelled:
        yield isinstance(behavior, Block) and behavior.head.startswith("worker")
    for member in behavior.members if isinstance(behavior, Block) else ():
        yield from _labels(member)


class _Text:
    """The text of one scenario.

    Args:
        labels: Result of `_labels` for it.
        mirrored: See `Program.text`.
    """

    def __init__(self, labels: tuple[bool, ...], mirrored: bool) -> None:
        self._all = [f"b{number}" for number in range(len(labels))]
        self._workers = [label for label, is_worker in zip(self._all, labels, strict=True) if is_worker]
        self._mirrored = mirrored
        self._given = iter(self._all)
        self._numbers = itertools.count()

    def line(self, line: Line) -> str | None:
        """Return the text of a line, or None to omit it."""
        names = {"number": str(next(self._numbers))}
        if self._all:
            names["any"] = self._all[line.pick % len(self._all)]
        if len(self._all) > 1:
            names["other"] = self._all[(line.pick + 1 + line.pick // 7 % (len(self._all) - 1)) % len(self._all)]
        if self._workers:
            names["worker"] = self._workers[line.pick % len(self._workers)]
        try:
            return line.template.format_map(names)
        except KeyError:
            return line.instead

    def behavior(self, behavior: Behavior, indent: int) -> list[str]:
        """The lines of a behavior."""
        blank = " " * indent
        label = f"{next(self._given)}: " if behavior.is_labelled else ""
        if isinstance(behavior, Statement):
            return [f"{blank}{label}{self.line(behavior.line)}"]
        members = [self.behavior(member, indent + 4) for member in behavior.members]
        if self._mirrored and behavior.head.startswith("parallel"):
            primary = 1 if "overlap" in behavior.head else 0
            members[primary:] = reversed(members[primary:])
        shown = [text for line in behavior.within if (text := self.line(line)) is not None]
        within = [f"{blank}with:", *(f"{blank}    {text}" for text in shown)] if shown else []
        if not members:
            return [f"{blank}{label}{behavior.head}{' with:' if within else ''}", *within[1:]]
        return [f"{blank}{label}{behavior.head}:", *itertools.chain.from_iterable(members), *within]
