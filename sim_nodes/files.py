"""World files, the files that they name, and folders of them that requests name."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from importlib import resources
from itertools import chain, islice
from pathlib import Path
from urllib.parse import unquote

from pydantic import BaseModel, ConfigDict

from seoro.bridges.models import files_in
from seoro.files.inputs import resolved

NAME = r"^[A-Za-z][A-Za-z0-9_-]{0,63}$"
"""Pattern of names of entities and parts of robots."""
FILE = "file://"
MAX_FILES = 1000  # examined for one list


class Declared(BaseModel):
    """Base of the parts of a file. Unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)


def resolve_folders(sources: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Resolve folders given as absolute paths or `file://PATH`; returns them, and messages on invalid ones."""
    folders = {source: Path(unquote(source.removeprefix(FILE))) for source in sources}
    unknown = [source for source, folder in folders.items() if not (folder.is_absolute() and folder.is_dir())]
    known = [resolved(folder) for source, folder in folders.items() if source not in unknown]
    return known, [f"folder not found: {source!r}" for source in unknown]


def list_files(
    own: Iterable[tuple[str, Path]], sources: Sequence[str], suffixes: Container[str], prefix: str = ""
) -> tuple[list[tuple[str, Path]], str]:
    """List own files and those in given folders.

    Args:
        own: Names and paths of own files.
        sources: See `resolve_folders`.
        suffixes: Suffixes of the files in folders.
        prefix: Prefix of the paths that name files in folders.

    Returns:
        Names and paths of the first `MAX_FILES` files, and descriptions of problems, one sentence each.
    """
    folders, problems = resolve_folders(sources)
    given = ((f"{prefix}{path.as_posix()}", path) for folder in folders for path in files_in(folder, suffixes))
    files = chain(own, given)
    found = dict(islice(files, MAX_FILES))
    if next(files, None) is not None:
        problems.append(f"ignored further files after the first {MAX_FILES}")
    return list(found.items()), "; ".join(problems)


def bundled_names(package: str) -> tuple[str, ...]:
    """Return the names of the YAML files of a package, without suffix, sorted."""
    files = resources.files(package).iterdir()
    return tuple(sorted(entry.name.removesuffix(".yaml") for entry in files if entry.name.endswith(".yaml")))
