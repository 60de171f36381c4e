"""`seoro exec --live-tree`: the tree of running behaviors, redrawn as it changes.

A thread draws the tree `RATE` times a second with the current time; the run itself only records changes. The last
frame stays on the terminal after the run, and later output is printed below it.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Final, TextIO

import anyio.to_thread
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from seoro.cli.output import Progress
from seoro.cli.terminal import use_colour
from seoro.cli.tree import Node, Row, Tree
from seoro.files.inputs import Kind, read_input
from seoro.runtime.verdict import Verdict
from seoro.text.printable import one_line, printable

RATE: Final = 6.0  # [Hz]
_MESSAGES: Final = 6  # lines for logs
_VARIABLES: Final = 4
_SMALLEST: Final = 4  # lines of the tree at least, at any height of the terminal

_MARKS = {
    "running": (">", "cyan"),
    "succeeded": ("+", "green"),
    "failed": ("x", "red"),
    "cancelled": ("-", "yellow"),
}
_LEVELS = {"warning": "yellow", "error": "red", "debug": "dim"}


class LiveTree:
    """Trace observer that draws a tree; it has the methods of `Progress`, which prints after the run.

    Args:
        file: Terminal to draw on.
    """

    def __init__(self, file: TextIO) -> None:
        self._after = Progress(file)
        self._console = Console(file=file, no_color=not use_colour(file), highlight=False)
        self._tree = Tree()
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._over = threading.Event()
        self._head: list[str] = []
        self._clock: Callable[[], float] = lambda: 0.0
        self._thread: threading.Thread | None = None

    def record(self, record: dict[str, Any]) -> None:
        """Update the tree with a record of the trace."""
        with self._lock:
            self._tree.record(record)
        if self._thread is None:
            self._thread = threading.Thread(target=self._draw, name="live tree", daemon=True)
            self._thread.start()
        self._changed.set()

    def set_clock(self, clock: Callable[[], float]) -> None:
        """Set the clock whose time is shown."""
        self._clock = clock

    def print_line(self, text: str) -> None:
        """Print a line."""
        if self._over.is_set():
            self._after.print_line(text)
        else:
            self._head += text.strip().splitlines()
            self._changed.set()

    def print_output(self, line: str) -> None:
        """Show a line printed by the process of the run among the messages."""
        with self._lock:
            self._tree.messages.append((self._clock(), "info", line))
        self._changed.set()

    async def end_of_run(self) -> None:
        """Draw the last frame; later lines are printed below it."""
        self._over.set()
        self._changed.set()
        if self._thread is not None:
            await anyio.to_thread.run_sync(self._thread.join, abandon_on_cancel=True)
        elif self._head:
            self._after.print_line("\n".join(self._head))

    async def finish(self) -> None:
        """Wait until all output is printed."""
        if not self._over.is_set():
            await self.end_of_run()
        await self._after.finish()

    def print_verdict(self, verdict: Verdict) -> None:
        """Print the verdict of a run."""
        self._after.print_verdict(verdict)

    # -------------------------------------------------------- the thread that draws

    def _draw(self) -> None:
        display = Live(console=self._console, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)
        with suppress(OSError, ValueError), display as live:  # the terminal is closed
            while not self._over.is_set():
                live.update(self._frame(), refresh=True)
                self._over.wait(1 / RATE)
                if self._tree.clock == "virtual":  # it stands still between records
                    self._changed.wait()
                    self._changed.clear()
            live.update(self._frame(), refresh=True)

    def _frame(self) -> Group:
        height = self._console.size.height - 1
        with self._lock:
            messages = list(self._tree.messages)
            variables = list(self._tree.variables.items())[-_VARIABLES:]
            # A frame higher than the terminal would scroll.
            below = min(len(messages), _MESSAGES) + len(variables)
            room = height - len(self._head) - 1
            below = min(below, room // 3)
            rows = self._tree.rows(max(_SMALLEST, room - below))
            now = max(self._tree.time, self._clock())
        lines = [Text(line, style="bold") for line in self._head[-3:]]
        lines += [_row(row, now) for row in rows]
        shown = [
            *[
                Text(f"  {name} = {json.dumps(value, ensure_ascii=False)}", style="cyan")
                for name, value in variables
            ],
            *[_message(*message) for message in messages[-_MESSAGES:]],
        ]
        lines += shown[-below:] if below else []
        for line in lines:
            line.no_wrap, line.overflow = True, "ellipsis"
        return Group(*lines[:height])


def _row(row: Row, now: float) -> Text:
    indent = "  " * row.depth
    if row.node is None:
        return Text(f"{indent}  ... and {row.folded} more running", style="dim")
    node = row.node
    is_waiting = node.end is None and node.type == "wait"
    mark, style = ("~", "cyan") if is_waiting else _MARKS[node.status]
    is_leaf = node.type in ("action", "wait", "emit", "call")
    text = Text(f"{indent}{mark} ", style=style)
    text.append(_title(node), style="bold" if is_leaf and node.end is None else "")
    if node.end is None:
        text.append(f"  {now - node.start:.1f} s", style=style)
    else:
        duration = node.end - node.start
        text.append("" if node.status == "succeeded" else f"  {node.status}", style=style)
        text.append(f"  {duration:.1f} s" if duration else "", style="dim")
        text.append(f"  {printable(node.reason)}" if node.reason else "", style=style)
    if row.folded:
        text.append(f"  ({row.folded} ended)", style="dim")
    return text


def _title(node: Node) -> str:
    if node.type in ("wait", "emit"):
        return printable(_source_text(node.source)) or node.name
    return printable(node.name if node.type in (node.name, "action") else f"{node.type} {node.name}")


def _message(when: float, level: str, text: str) -> Text:
    shown = one_line(text)
    return Text.assemble((f"{when:9.3f} s  ", "dim"), (shown, _LEVELS.get(level, "")))


def _source_text(source: str) -> str:
    """Read the rest of the line at a source location (`file:line:column`)."""
    name, line, column = source.rsplit(":", 2)
    lines = _lines(name)
    return lines[int(line) - 1][int(column) - 1 :].strip() if int(line) <= len(lines) else ""


@cache
def _lines(name: str) -> list[str]:
    try:
        return read_input(Path(name), Kind.SCENARIO).decode(errors="replace").splitlines()
    except OSError:
        return []
