"""The files of worlds. Their form is a matter of simulators: a process of theirs says what a world names."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from seoro.errors import InvalidUse
from seoro.input_files import Kind, open_input

TIMEOUT: Final = 60.0  # [s]
SUFFIXES: Final = frozenset({".yaml", ".yml"})
XML_SUFFIXES: Final = frozenset({".sdf", ".urdf", ".world", ".xml"})
FILE_ATTRIBUTES: Final = ("file", "filename")  # of elements, which name files; so does the text of `uri`
FILE_SCHEME: Final = "file://"


def is_world_file(world: str) -> bool:
    """Whether a world is named by its file, and not by a name that simulators know."""
    return Path(world).suffix in SUFFIXES


def is_file_uri(world: str) -> bool:
    """Whether a world is named by `file://`."""
    return world.startswith(FILE_SCHEME)


def file_here(world: str) -> Path | None:
    """The file of this machine that a world of a foreign simulator names; None if the name is that simulator's."""
    path = Path(unquote(world.removeprefix(FILE_SCHEME)) if is_file_uri(world) else world)
    return path if path.is_file() else None


def files_of_foreign_world(world: Path) -> list[Path]:
    """A world file of a simulator of a ROS 2 system with the files and folders beside it that it names.

    Those of YAML are seoro's; of XML, such as SDF, what it names by relative paths goes along, and of others only
    the file itself.

    Raises:
        InvalidUse: As `files_of_world`, or it cannot be read.
    """
    return files_of_world(str(world)) if is_world_file(str(world)) else [*_with_named(world, set())]


def _with_named(file: Path, seen: set[Path]) -> Iterator[Path]:
    """A file, with those that it names if it is XML, and those that they name."""
    if file in seen:
        return
    seen.add(file)
    yield file
    if file.suffix not in XML_SUFFIXES:
        return
    for named in _named_in(file):
        for each in sorted(named.rglob("*")) if named.is_dir() else [named]:
            if each.is_file():
                yield from _with_named(each, seen)


def _named_in(file: Path) -> list[Path]:
    """What an XML file names by paths relative to it."""
    from xml.etree import ElementTree  # noqa: PLC0415 - takes long to load

    try:
        with open_input(file, Kind.WORLD) as stream:
            tree = ElementTree.parse(stream)  # noqa: S314 - of the user's own, and the parser limits what entities become
    except (OSError, ElementTree.ParseError) as error:
        raise InvalidUse(f"cannot read the world file {file}: {error}") from error
    names = [element.text or "" for element in tree.iter("uri")]
    names += [element.get(attribute, "") for element in tree.iter() for attribute in FILE_ATTRIBUTES]
    stripped = {name.strip() for name in names} - {""}
    return [file.parent / name for name in sorted(stripped) if "://" not in name and not Path(name).is_absolute()]


def files_of_world(world: str) -> list[Path]:
    """A world file with all that it names.

    Raises:
        InvalidUse: One of them is not there, or is wrong, as a run here would say it; or there is no simulator
            here that could tell.
    """
    command = [sys.executable, "-m", "sim_nodes.worlds.files", world]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired as error:
        raise InvalidUse(f"the world {world} was not read within {TIMEOUT:g} s") from error
    if done.returncode == 0:
        return [Path(file) for file in json.loads(done.stdout)]
    if "ModuleNotFoundError" in done.stderr:
        raise InvalidUse(
            "which files a world names is known to simulators only, and what these need is not installed here",
            help="pip install 'seoro[node]'; or name a world that the executor's simulators have, such as `maze`",
        )
    raise InvalidUse(done.stderr.strip() or f"the world {world} cannot be read")
