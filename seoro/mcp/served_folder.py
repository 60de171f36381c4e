"""The folder of a server; names of requests cannot lead out of it."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.runtime.execution.outputs import TRACE

_SUFFIX: Final = ".osc"
_LONGEST: Final = 1000  # [characters] of a name
_SHOWN: Final = 100  # [characters] of a name in messages


class ServedFolder:
    """The folder of a server.

    Args:
        root: The folder.

    Raises:
        UsageError: It is not a folder.
    """

    def __init__(self, root: Path) -> None:
        self.root = resolved(root)
        if not self.root.is_dir():
            raise UsageError(f"not a folder: {root}", help="name the folder with the scenarios")

    def path(self, name: str) -> Path:
        """Return the path of a name, with links resolved.

        Args:
            name: Path relative to the folder; empty for the folder itself.

        Raises:
            UsageError: The path is invalid, missing, or outside of the folder.
        """
        if "\0" in name or len(name) > _LONGEST:
            raise UsageError(f"invalid path `{name[:_SHOWN]}`", help="name a path below the served folder")
        found = resolved(self.root / name)
        if not found.is_relative_to(self.root):
            raise UsageError(
                f"`{name[:_SHOWN]}` is outside of the served folder", help="name a path relative to this folder"
            )
        if not found.exists():
            raise UsageError(f"path not found: `{name[:_SHOWN]}`", help="list scenarios or runs to see the paths")
        return found

    def name(self, path: Path) -> str | None:
        """Return the name of a path; None if the path is outside of the folder."""
        found = resolved(path)
        return found.relative_to(self.root).as_posix() if found.is_relative_to(self.root) else None

    def scenario(self, name: str) -> Path:
        """Return the path of a scenario file.

        Raises:
            UsageError: As `path`, or it is not a scenario file.
        """
        found = self.path(name)
        if found.suffix != _SUFFIX or not found.is_file():
            raise UsageError(f"not a scenario file: `{name[:_SHOWN]}`", help=f"name a file ending with {_SUFFIX}")
        return found

    def trace(self, name: str) -> Path:
        """Return the path of the trace of a run.

        Args:
            name: The output folder of the run, or its trace.

        Raises:
            UsageError: As `path`, or the folder has no trace.
        """
        found = self.path(name)
        if found.is_dir():
            return self.path(f"{name.rstrip('/')}/{TRACE}" if name else TRACE)
        if not found.is_file():
            raise UsageError(f"not a trace: `{name[:_SHOWN]}`", help="name the output folder of a run")
        return found

    def folder(self, name: str) -> Path:
        """Return the path of a folder.

        Raises:
            UsageError: As `path`, or it is not a folder.
        """
        found = self.path(name)
        if not found.is_dir():
            raise UsageError(f"not a folder: `{name[:_SHOWN]}`")
        return found
