"""Files of worlds. Simulators define their format, so a process of `sim_nodes` lists them."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.files.world_names import WORLD_FILES, WorldName

PROCESSOR_TIME: Final = 60  # [s] for reading a world
TIMEOUT: Final = 1800.0  # [s]; a busy machine takes many times as long
LIMITED: Final = 'ulimit -S -t "$1"; shift; exec "$@"'
XML_SUFFIXES: Final = frozenset({".sdf", ".urdf", ".world", ".xml"})
FILE_ATTRIBUTES: Final = ("file", "filename")  # XML attributes that name files, like the text of `uri`
FILE_SCHEME: Final = "file://"


def is_world_file(world: str) -> bool:
    """Return whether a world is a file, not a name known to simulators."""
    return WorldName.parse(world).is_file


def is_file_uri(world: str) -> bool:
    """Return whether a world is a `file://` URI."""
    return world.startswith(FILE_SCHEME)


def file_here(world: str) -> Path | None:
    """Return the local file of a world of a foreign simulator; None if it is a name of that simulator."""
    path = Path(unquote(world.removeprefix(FILE_SCHEME)) if is_file_uri(world) else world)
    return path if path.is_file() else None


def files_of_foreign_world(world: Path) -> list[Path]:
    """List a world file for a simulator of a ROS 2 system, with the files that it names.

    YAML files are worlds of seoro. XML files, such as SDF, are listed with the files that they name by relative
    paths; other files are listed alone.

    Raises:
        UsageError: As `files_of_world`, or the file cannot be read.
    """
    return files_of_world(str(world)) if world.suffix in WORLD_FILES else [*_with_named(world, set())]


def _with_named(file: Path, seen: set[Path]) -> Iterator[Path]:
    """Yield a file; for XML, also the files that it names, recursively."""
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
    """Return the files that an XML file names by relative paths."""
    from xml.etree import ElementTree  # noqa: PLC0415 - takes long to load

    try:
        with open_input(file, Kind.WORLD) as stream:
            tree = ElementTree.parse(stream)  # noqa: S314 - file of the user; the parser limits entities
    except (OSError, ElementTree.ParseError) as error:
        raise UsageError(f"cannot read the world file {file}: {error}") from error
    names = [element.text or "" for element in tree.iter("uri")]
    names += [element.get(attribute, "") for element in tree.iter() for attribute in FILE_ATTRIBUTES]
    stripped = {name.strip() for name in names} - {""}
    return [file.parent / name for name in sorted(stripped) if "://" not in name and not Path(name).is_absolute()]


def files_of_world(world: str) -> list[Path]:
    """List a world file with all files that it names.

    Raises:
        UsageError: A file is missing or invalid, or no simulator is installed to read it.
    """
    found = _ask_simulators("files", [world])
    if found is None:
        raise UsageError(
            "cannot list the files of the world: the packages of simulators are not installed here",
            help="pip install 'seoro[node]', or name a world of the executor's simulators, such as `maze`",
        )
    return [Path(file) for file in json.loads(found)]


def check_worlds(worlds: Sequence[str]) -> None:
    """Check the keys and values of worlds, if the packages of simulators are installed here.

    Args:
        worlds: Names or paths of worlds, perhaps with parameters.

    Raises:
        UsageError: A world is unknown, or a key or a value is invalid.
    """
    _ask_simulators("check", worlds)


def _ask_simulators(module: str, worlds: Sequence[str]) -> str | None:
    """Return the output of a module of `sim_nodes.worlds`; None if the packages of simulators are missing.

    Raises:
        UsageError: A world is invalid.
    """
    command = [sys.executable, "-m", f"sim_nodes.worlds.{module}", *worlds]
    limited = ["/bin/sh", "-c", LIMITED, "sh", str(PROCESSOR_TIME), *command]
    try:
        done = subprocess.run(limited, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired as error:
        raise UsageError(f"reading the world {worlds[0]} took more than {TIMEOUT:g} s") from error
    if done.returncode == -signal.SIGXCPU:
        raise UsageError(f"reading the world {worlds[0]} took more than {PROCESSOR_TIME} s of processor time")
    if done.returncode == 0:
        return done.stdout
    if "ModuleNotFoundError" in done.stderr:
        return None
    raise UsageError(done.stderr.strip() or f"cannot read the world {worlds[0]}")
