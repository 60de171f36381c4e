"""Explanations of the codes of messages, for `seoro explain` and the documentation.

Each code has a file in `explanations/`: title, meaning, a wrong example with its message, and a right example.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen

FOLDER: Final = Path(__file__).with_name("explanations")
EXAMPLE: Final = "example.osc"  # name of examples in their messages
PHASES: Final = {
    "E01": "Reading and parsing",
    "E02": "Imports and names",
    "E03": "Types and expressions",
    "E04": "Behaviors and instantiation",
    "E05": "Coverage and runs",
    "E06": "Python",
    "E07": "Suspicious code",
}
_CODE: Final = re.compile(r"E\d{4}")
_TEXT: Final = re.compile(
    r"# (?P<code>E\d{4}): (?P<title>[^\n]+)\n\n(?P<meaning>.+?)\n\n"
    r"## Wrong\n\n```osc\n(?P<wrong>.+?)```\n(?P<files>(?:\n`[^`\n]+`:\n\n```.+?```\n)*)\n"
    r"```console\n\$ (?P<command>[^\n]+)\n(?P<message>.*?)```\n\n"
    r"## Right\n\n```osc\n(?P<right>.+?)```\n(?P<right_files>(?:\n`[^`\n]+`:\n\n```.+?```\n)*)"
    r"(?:\n```console\n\$ (?P<other_command>[^\n]+)\n```\n)?",
    re.DOTALL,
)


class Example(Frozen):
    """A wrong and a right example.

    Args:
        wrong: The text of the wrong example.
        command: The command that prints the message.
        message: Its output on stderr.
        right: The text of the right example.
        right_command: The command that succeeds with it.
        files: Texts of other files, by path.
        right_files: Other files that the right example changes or adds.
    """

    wrong: str
    command: str
    message: str
    right: str
    right_command: str
    files: Mapping[str, str]
    right_files: Mapping[str, str]


class Explanation(Frozen):
    """Explanation of a code.

    Args:
        code: The code, such as `E0312`.
        title: One line, without a full stop.
        meaning: Cause of the message; Markdown.
        text: The whole explanation with the examples; Markdown.
        example: The examples.
    """

    code: str
    title: str
    meaning: str
    text: str
    example: Example

    @property
    def phase(self) -> str:
        """Name of the phase that reports the code."""
        return PHASES[self.code[:3]]


def codes() -> tuple[str, ...]:
    """Return all codes, in order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("E????.md")))


def explanation(code: str) -> Explanation | None:
    """Return the explanation of a code, in upper or lower case; None if the code is unknown."""
    code = code.upper()
    path = FOLDER / f"{code}.md"
    if not _CODE.fullmatch(code) or not path.exists():
        return None
    return parse(path.read_text(encoding="utf-8"))


def explanations() -> tuple[Explanation, ...]:
    """Return the explanations of all codes, in order."""
    return tuple(filter(None, map(explanation, codes())))


def near_codes(code: str) -> str:
    """Return help that suggests similar codes; empty without any."""
    code = code.upper()
    phase = [known for known in codes() if known.startswith(code[:3])]
    if not _CODE.fullmatch(code) or not phase:
        return near(code, codes())
    nearest = sorted(phase, key=lambda known: abs(int(known[1:]) - int(code[1:])))[:3]
    return f"did you mean {listing(sorted(nearest), 'or')}?"


def parse(text: str) -> Explanation:
    """Read the text of an explanation.

    Raises:
        ValueError: The text has an invalid form.
    """
    found = _TEXT.fullmatch(text)
    if found is None:
        raise ValueError(f"invalid explanation of a code: {text[:40]!r}")
    example = Example(
        found["wrong"],
        found["command"],
        found["message"],
        found["right"],
        found["other_command"] or found["command"],
        _files(found["files"]),
        _files(found["right_files"]),
    )
    return Explanation(found["code"], found["title"], found["meaning"], text, example)


def _files(text: str) -> dict[str, str]:
    """Read the files of an example, each with its path before it."""
    return dict(re.findall(r"^`([^`\n]+)`:\n\n```\w+\n(.*?)```$", text, re.DOTALL | re.MULTILINE))
