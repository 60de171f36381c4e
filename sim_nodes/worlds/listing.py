"""Lists available worlds: worlds that come with the node, and worlds in given folders."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from seoro.files.yaml_lines import FileError, read_text
from sim_nodes.files import list_files
from sim_nodes.worlds.loader import WorldError, available_worlds, read_world_file


@dataclass(frozen=True)
class WorldEntry:
    """A world that can be loaded: its name or file, and its description and tags."""

    source: str
    description: str
    tags: tuple[str, ...]


def find_worlds(sources: Sequence[str]) -> tuple[list[WorldEntry], str]:
    """List all worlds, and describe problems, one sentence each.

    Only world files are read; the files that they name are checked when a world is loaded.
    """
    own = ((name, Path(__file__).with_name(f"{name}.yaml")) for name in available_worlds())
    files, problems = list_files(own, sources, {".yaml"})
    return list(_worlds(files)), problems


def _worlds(files: Iterable[tuple[str, Path]]) -> Iterator[WorldEntry]:
    for source, path in files:
        try:
            file, _ = read_world_file(read_text(path), source)
        except (FileError, WorldError):  # such as the declaration of a robot
            continue
        yield WorldEntry(source, file.description, file.tags)
