"""Check that files in literal arguments exist on this machine."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from seoro.lang.traits import ParameterTrait

_SCHEME: Final = "://"
_FILE_SCHEME: Final = "file://"
_SUFFIXES: Final = frozenset({".sdf", ".urdf", ".world", ".xml", ".yaml", ".yml"})  # of models and worlds


def is_missing(text: str, trait: ParameterTrait, files: Iterable[Path | None]) -> bool:
    """Return whether a text names a missing file or folder.

    Names that simulators resolve, such as `garden://pot.sdf` or `maze`, do not count.

    Args:
        text: The literal.
        trait: Trait of the parameter: `FILE` or `URI`.
        files: Scenario files whose folders are searched, besides the working directory.
    """
    if trait is ParameterTrait.URI:
        if text.startswith(_FILE_SCHEME):
            text = unquote(text.removeprefix(_FILE_SCHEME))
        elif _SCHEME in text or Path(text).suffix not in _SUFFIXES:
            return False
    folders = [Path(), *(file.parent for file in files if file is not None)]
    return bool(text) and not any(_exists(folder / text) for folder in folders)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # too long, not permitted, or with a zero in it
        return False
