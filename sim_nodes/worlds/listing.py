"""Which worlds there are: those that come with the node, and those in folders that are named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

from sim_nodes.files import FileError, read_text
from sim_nodes.sources import files_of, folders_of
from sim_nodes.worlds.loader import WorldError, available_worlds, read_world_file

MAX_FILES = 1000  # that are looked at for one list


@dataclass(frozen=True)
class Listed:
    """A world that can be loaded: by its name or the path of its file, and what its file says of it."""

    source: str
    description: str
    tags: tuple[str, ...]


def find_worlds(sources: Sequence[str]) -> tuple[list[Listed], str]:
    """All worlds, and what was not looked at, in sentences, if there is anything.

    Whether all that a world names is there, and right, is found out when it is loaded.
    """
    folders, problems = folders_of(sources)
    own = ((name, Path(__file__).with_name(f"{name}.yaml")) for name in available_worlds())
    files = chain(own, ((str(path), path) for path in files_of(folders, {".yaml"})))
    found = list(_worlds(islice(files, MAX_FILES)))
    if next(files, None) is not None:
        problems.append(f"after {MAX_FILES} files no more were looked at")
    return found, "; ".join(problems)


def _worlds(files: Iterator[tuple[str, Path]]) -> Iterator[Listed]:
    for source, path in files:
        try:
            file, _ = read_world_file(read_text(path), source)
        except (FileError, WorldError):  # such as the declaration of a robot
            continue
        yield Listed(source, file.description, file.tags)
