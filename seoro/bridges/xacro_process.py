"""Expands one xacro file: `python -m seoro.bridges.xacro_process FILE [KEY=VALUE ...]`.

Prints the URDF and the paths of all files that were read, with zero bytes between, or an error.

Limits hold for the whole process: processor time, memory, and no bytes written to files.
"""

from __future__ import annotations

import contextlib
import io
import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from seoro.bridges.model_files import package_folder
from seoro.bridges.xacro_files import Expanded

FAILED: Final = 2  # exit status
MAX_TIME: Final = 20  # [s] of the processor
MAX_MEMORY: Final = 1 << 30  # [bytes]
MAX_TEXT: Final = 4 << 20  # [characters] of the URDF, as of other models


class _Packages:
    """Folders of packages, by name, for `$(find NAME)`."""

    def __init__(self, model: Path) -> None:
        self._model = model
        self.found: dict[str, Path] = {}

    def find(self, name: str) -> str:
        folder = package_folder(name, self._model)
        if folder is None:
            raise LookupError(
                f"unknown package {name!r} of $(find {name}); expected it in a folder above the file, "
                "or in one that ROS_PACKAGE_PATH or AMENT_PREFIX_PATH names"
            )
        self.found[name] = folder
        return str(folder)

    def with_uris(self, text: str) -> str:
        """Replace the folders by `package://NAME`, which is the same on every machine."""
        for name, folder in sorted(self.found.items(), key=lambda item: -len(str(item[1]))):
            for prefix in (f"file://{folder}/", f"{folder}/"):
                text = text.replace(prefix, f"package://{name}/")
        return text


def expand_here(path: Path, arguments: Mapping[str, str]) -> Expanded:
    """Expand a file in this process, which can do so once: xacro keeps global state."""
    import xacro  # noqa: PLC0415 - after the limits are set
    from xacro import substitution_args  # noqa: PLC0415

    packages = _Packages(path)
    substitution_args._eval_find = packages.find
    substitution_args._eval_dict["find"] = packages.find
    document: Any = xacro.process_file(str(path), mappings=dict(arguments))
    text = packages.with_uris(document.toprettyxml(indent="  "))
    if len(text) > MAX_TEXT:
        raise ValueError(f"the expanded file has more than {MAX_TEXT} characters")
    paths = dict.fromkeys(Path(each).resolve() for each in (path, *xacro.all_includes))
    return Expanded(text, tuple(paths))


def main(path: str, *pairs: str) -> int:
    """Expand a file with arguments `KEY=VALUE`; returns the exit status."""
    arguments = {key: value for key, _, value in (pair.partition("=") for pair in pairs)}
    resource.setrlimit(resource.RLIMIT_CPU, (MAX_TIME, MAX_TIME))
    resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            expanded = expand_here(Path(path), arguments)
    except (Exception, SystemExit) as error:  # xacro raises what expressions raise
        sys.stderr.write(_reason(error))
        return FAILED
    sys.stdout.buffer.write(
        "\0".join((expanded.text, *map(str, expanded.paths))).encode("utf-8", "surrogateescape")
    )
    return 0


def _reason(error: BaseException) -> str:
    """Return the message of an error in one line, with that of its cause."""
    words = str(error) or repr(error)
    cause = getattr(error, "exc", None)  # of xacro
    if cause is not None and (not str(cause) or str(cause) not in words):
        words += f": {cause!r}"
    return " ".join(words.split())


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
