"""Paths of the documentation for new users, typed as they stand there, with the built wheel in an empty folder.

A path costs the time to type its commands, five seconds to copy each file, and the processor time of its commands.
The user's own scenario of the first path is typed.
"""

from __future__ import annotations

import logging
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

import pytest
import trimesh

from tests.distribution.typing import SPEED, Person
from tests.tools.code_blocks import Block, blocks_in, commands_in, matches

ROOT: Final = Path(__file__).parents[2]
TUTORIAL: Final = ROOT / "docs/tutorial"
COPYING: Final = 5.0  # [s] for a file


class Way(NamedTuple):
    """A path of the documentation.

    Args:
        page: Page of the tutorial.
        heading: Heading above its blocks; those of the next headings do not belong to it.
        limit: Limit of its time [s].
        before: Headings above blocks that it needs.
        is_typed: Whether its files are typed.
    """

    page: str
    heading: str
    limit: float
    before: tuple[str, ...] = ()
    is_typed: bool = False


WAYS: Final = {
    "own scenario": Way("first_scenario", "Run", 120.0, is_typed=True),
    "own robot": Way("first_robot", "The first drive", 300.0, before=("The robot",)),
    "test in CI": Way("many_runs", "A test in CI", 300.0, before=("A project",)),
    "sweep": Way("many_runs", "A sweep with plots", 180.0, before=("A project",)),
}


def section(page: str, heading: str) -> list[Block]:
    """Return the blocks below a heading of a page."""
    path = TUTORIAL / f"{page}.md"
    lines = path.read_text().splitlines()
    start = lines.index(f"## {heading}") + 1
    end = next((number for number, line in enumerate(lines[start:], start) if line.startswith("## ")), len(lines))
    return [block for block in blocks_in(path) if start < block.line <= end]


@pytest.fixture(scope="module")
def programs(wheel: Path, installed: Path) -> Path:
    """Return the folder with the command of the installed wheel."""
    command = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(installed),
        "install",
        "--quiet",
        "--no-deps",
        "--no-index",
    ]
    subprocess.run(
        [*command, "--force-reinstall", "--disable-pip-version-check", str(wheel)], check=True, timeout=120
    )
    return installed.parent


@pytest.fixture
def person(programs: Path, tmp_path: Path) -> Iterator[Person]:
    """Return a person at a shell in an empty folder."""
    folder = tmp_path / "empty"
    folder.mkdir()
    made = Person(folder, programs)
    yield made
    made.close()


def with_meshes(urdf: str, folder: Path) -> str:
    """Write the shapes of a URDF to files, and return the URDF with them."""
    shapes = {
        '<box size="0.4 0.24 0.14"/>': trimesh.creation.box((0.4, 0.24, 0.14)),
        '<cylinder radius="0.06" length="0.03"/>': trimesh.creation.cylinder(0.06, 0.03),
        '<sphere radius="0.02"/>': trimesh.creation.icosphere(radius=0.02),
    }
    for number, (shape, mesh) in enumerate(shapes.items()):
        assert shape in urdf
        mesh.export(folder / f"part_{number}.stl")
        urdf = urdf.replace(shape, f'<mesh filename="part_{number}.stl"/>')
    return urdf


@pytest.mark.more
@pytest.mark.engine("mujoco")
@pytest.mark.parametrize("name", WAYS)
def test_a_path_works_as_it_is_typed_and_is_short(name: str, person: Person, tmp_path: Path) -> None:
    way, folder, copied = WAYS[name], tmp_path / "empty", 0
    blocks = [block for heading in (*way.before, way.heading) for block in section(way.page, heading)]
    for block in blocks:
        if block.name:
            is_model = block.name == "robot.urdf"  # the user has it
            (folder / block.name).write_text(with_meshes(block.text, folder) if is_model else block.text)
            person.characters += len(block.text) if way.is_typed else 0
            copied += not way.is_typed and not is_model
        elif block.language == "console" and not block.reason:
            for command, expected in commands_in(block):
                status, shown = person.type(command)
                assert status == block.status, f"`{command}` printed:\n{shown}"
                assert not expected or matches(expected, shown), f"`{command}` printed:\n{shown}"
    if name == "test in CI":
        pushed(person, blocks, tmp_path)
    processor = person.close()
    taken = person.characters / SPEED + COPYING * copied + processor
    logging.getLogger(__name__).info("%s: %.0f s, of which %.0f s computing", name, taken, processor)
    assert taken < way.limit


def pushed(person: Person, blocks: list[Block], tmp_path: Path) -> None:
    """Type the commands that push the project, to a repository in a folder."""
    remote = tmp_path / "remote.git"
    subprocess.run(["git", "init", "--quiet", "--bare", str(remote)], check=True)
    [block] = [block for block in blocks if block.language == "sh"]
    for line in block.text.splitlines():
        if line == "git push":
            assert person.type(f"git remote add origin {remote} && {line} --set-upstream origin HEAD")[0] == 0
        else:
            assert person.type(line)[0] == 0
    command = ["git", "-C", str(remote), "ls-tree", "-r", "--name-only", "HEAD"]
    listed = subprocess.run(command, capture_output=True, text=True, check=True)
    names = listed.stdout.split()
    assert ".github/workflows/scenarios.yml" in names
    assert not [each for each in names if re.search(r"cache|\.pyc|^out/", each)]
