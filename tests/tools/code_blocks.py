"""Code blocks of pages: what each contains, and how a test executes it.

A block is executed, or a comment above it has the reason why not:

- a block below a line such as "`lab.yaml`:" is a file of the page. Scenario files have to pass `seoro check`;
- a block `console` has commands after `$`, with the output that they print. `...` stands for any text;
- a block `osc` is a scenario file of its own; a block `python` is executed, and prints the block `text` after it;
- `<!-- not run: REASON -->` excuses a block, `<!-- exit status: N -->` expects a status of the last command,
  `<!-- has errors -->` expects that a scenario file has errors;
- `<!-- needs a simulator -->` marks commands whose project names a simulator.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

LANGUAGES: Final = frozenset({"osc", "python", "console"})
"""Languages of blocks that can be executed without a name."""

_FENCE: Final = re.compile(r"^( *)```(\S*)[^\n]*\n(.*?)^\1```", re.MULTILINE | re.DOTALL)
_COMMENT: Final = re.compile(r"<!-- (not run|exit status|has errors|needs a simulator)(?:: ([^\n]*?))? -->\n\s*$")
_NAME: Final = re.compile(r"^`([\w./-]+\.\w+)`:\n\s*$", re.MULTILINE)
_DIRECTIVES: Final = frozenset({"{toctree}", "{figure}", "{glossary}"})


class Block(NamedTuple):
    """A code block.

    Args:
        line: The line of its fence.
        language: Its language, or an empty text.
        text: Its lines.
        name: Name of the file that it shows, or an empty text.
        reason: Reason why it is not executed, or an empty text.
        status: Expected exit status of the last command.
        has_errors: Whether the scenario file has errors.
        is_marked: Whether a comment marks it as needing a simulator.
    """

    line: int
    language: str
    text: str
    name: str
    reason: str
    status: int
    has_errors: bool
    is_marked: bool

    @property
    def needs_simulator(self) -> bool:
        """Whether a command of it starts a simulator."""
        names_one = re.search(r"--sim |--lab |--rate max", self.text) is not None
        return self.language == "console" and (names_one or self.is_marked)


def blocks_in(page: Path) -> Iterator[Block]:
    """Yield the code blocks of a page."""
    text = page.read_text(encoding="utf-8")
    for fence in _FENCE.finditer(text):
        indent, language, body = fence.groups()
        if language in _DIRECTIVES:
            continue
        before = text[: fence.start()]
        comments: dict[str, str] = {}
        while comment := _COMMENT.search(before):
            comments[comment[1]] = comment[2] or ""
            before = before[: comment.start()]
        named = next((found for found in _NAME.finditer(before) if found.end() == len(before)), None)
        yield Block(
            line=text.count("\n", 0, fence.start()) + 1,
            language=language,
            text=re.sub(rf"^{indent}", "", body, flags=re.MULTILINE),
            name=named[1] if named else "",
            reason=comments.get("not run", ""),
            status=int(comments.get("exit status", 0)),
            has_errors="has errors" in comments,
            is_marked="needs a simulator" in comments,
        )


def is_covered(block: Block, before: Block | None) -> bool:
    """Whether a block is executed, is the output of the block before it, or has a reason.

    Args:
        block: The block.
        before: The block before it, if any.
    """
    is_output = block.language == "text" and before is not None and before.language == "python"
    return bool(block.reason or block.name or block.language in LANGUAGES or is_output)


def commands_in(block: Block) -> Iterator[tuple[str, list[str]]]:
    """Yield the commands of a console block, each with the lines that it prints."""
    command, lines = "", list[str]()
    for line in block.text.replace("\\\n", " ").splitlines():
        if line.startswith("$ "):
            if command:
                yield command, lines
            command, lines = line.removeprefix("$ "), []
        else:
            lines.append(line)
    if command:
        yield command, lines


def matches(expected: list[str], printed: str) -> bool:
    """Whether output is as shown, apart from empty lines.

    Args:
        expected: The lines; `...` alone stands for any lines, within a line for any characters.
        printed: The output.
    """
    shown = "".join(f"{line}\n" for line in printed.splitlines() if line.strip())
    pattern = "".join(
        r"(?:.*\n)*?" if line.strip() == "..." else ".*".join(map(re.escape, line.split("..."))) + r"[ \t]*\n"
        for line in expected
        if line.strip()
    )
    return re.fullmatch(pattern, shown) is not None
