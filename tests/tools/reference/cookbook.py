"""The cookbook, from the opening comments of its scenarios.

The first line of a scenario is a question, and the lines below answer it. Lines `# With OPTIONS it fails: REASON`
(or `is refused: CODE`) have options with which the scenario does not pass. A line `# $ COMMAND` replaces the usual
command.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from tests.tools.reference.tables import code, table

ROOT: Final = Path(__file__).parents[3]
FOLDER: Final = ROOT / "scenarios" / "cookbook"
FAILED, INVALID = 1, 2

_VARIATION: Final = re.compile(r"# With `([^`]+)` it (fails|is refused): (.+)")
_COMMAND: Final = "# $ "
_DIRECTIVE: Final = "# seoro: "


class Variation(NamedTuple):
    """Options with which a scenario does not pass.

    Args:
        options: Options of `seoro exec`.
        status: Exit status.
        reason: Part of the output.
    """

    options: str
    status: int
    reason: str


class Recipe(NamedTuple):
    """A scenario of the cookbook.

    Args:
        file: The scenario file.
        question: Its question.
        answer: Sentences that answer it.
        command: Command that runs it in the root of the repository.
        variations: Options with which it does not pass.
        source: Its text with directives, without the other lines of the opening comment.
    """

    file: Path
    question: str
    answer: str
    command: str
    variations: tuple[Variation, ...]
    source: str

    @property
    def group(self) -> str:
        """Title of the section of the page."""
        if "--ros" in self.command:
            return "ROS 2"
        return "Robots in a simulator" if "# seoro: simulators" in self.source else "The language"

    @property
    def anchor(self) -> str:
        """Anchor of its section."""
        return re.sub(r"[^\w -]", "", self.question.lower()).replace(" ", "-")

    @property
    def libraries(self) -> list[Path]:
        """Files of libraries beside the scenario that it imports."""
        names = re.findall(r"^import osc\.(\w+)", self.source, re.MULTILINE)
        return [path for name in names for path in sorted((FOLDER / "seoro.libraries").glob(f"{name}.*"))]


def recipes() -> list[Recipe]:
    """Return the scenarios of the cookbook, by name."""
    return [_read(path) for path in sorted(FOLDER.glob("*.osc"))]


def cookbook() -> str:
    """Return a table of the questions, and a section for each scenario."""
    found = recipes()
    rows = ((f"[{item.question}](#{item.anchor})", code(item.file.stem)) for item in found)
    parts = [table(("question", "scenario"), rows)]
    shown = set[Path]()
    for title in ("The language", "Robots in a simulator", "ROS 2"):
        parts.append(f"## {title}")
        for item in found:
            if item.group == title:
                parts += _section(item, [path for path in item.libraries if path not in shown])
                shown |= set(item.libraries)
    return "\n\n".join(part.rstrip("\n") for part in parts) + "\n"


def _read(path: Path) -> Recipe:
    """Read a scenario file."""
    head, body = path.read_text(encoding="utf-8").split("\n\n", maxsplit=1)
    question, *lines = head.splitlines()
    variations = [found for line in lines if (found := _VARIATION.fullmatch(line))]
    commands = [line.removeprefix(_COMMAND) for line in lines if line.startswith(_COMMAND)]
    directives = [line for line in lines if line.startswith(_DIRECTIVE)]
    is_simulated = any(" simulators " in line for line in directives)
    usual = f"seoro exec {path.relative_to(ROOT)} {'--rate max' if is_simulated else '--clock virtual'}"
    answer = [line for line in lines if not line.startswith((_COMMAND, _DIRECTIVE, "# With `"))]
    return Recipe(
        file=path,
        question=question.removeprefix("# "),
        answer=" ".join(line.removeprefix("# ") for line in answer),
        command=commands[0] if commands else usual,
        variations=tuple(
            Variation(each[1], FAILED if each[2] == "fails" else INVALID, each[3]) for each in variations
        ),
        source="\n".join([*directives, "", body] if directives else [body]),
    )


def _section(recipe: Recipe, libraries: Sequence[Path]) -> list[str]:
    """Return the parts of a section."""
    parts = [f"### {recipe.question}", recipe.answer, *_listing(recipe.file, recipe.source)]
    for path in libraries:
        parts += _listing(path, path.read_text(encoding="utf-8"))
    parts.append(f"```console\n$ {recipe.command}\n```")
    for each in recipe.variations:
        end = "it fails" if each.status == FAILED else "it is refused"
        parts.append(f"With `{each.options}` {end}: {each.reason}")
    return parts


def _listing(path: Path, text: str) -> list[str]:
    """Return a file with its name."""
    language = {".osc": "osc", ".py": "python"}[path.suffix]
    return [f"`{path.relative_to(FOLDER)}`:", f"```{language}\n{text.rstrip()}\n```"]
