"""Models by name: `name://path`, found along the model path.

The model path begins with the folders of the user, in order, each with a folder `name`. Packages in the
entry-point group `seoro.models` follow: `name = "package.module"` declares the folder of that module. Seoro's
own models come last. `file://` names a file directly.
"""

from __future__ import annotations

import sys
from collections.abc import Container, Iterator, Sequence
from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import quote, unquote

from seoro.bridges.model_files import InvalidModel, ModelFiles, gather
from seoro.bridges.xacro_files import MARK, SUFFIX
from seoro.deferred import dataclass
from seoro.files.path_mapping import Locate, unchanged_path

OWN_MODELS = Path(__file__).resolve().parent.parent / "models"


class ModelNotFound(Exception):
    """The model is unknown; the message lists the searched folders."""


@dataclass(frozen=True)
class ModelPath:
    """Search path of models.

    Args:
        folders: Folders of the user, searched first.
        locate: Maps absolute paths of files.
        expands: Whether xacro files may be expanded, which evaluates expressions in them.
    """

    folders: Sequence[Path] = ()
    locate: Locate = unchanged_path
    expands: bool = False

    def read(self, uri: str) -> ModelFiles:
        """Return a model with the files that it names; these are in the folders of models, or beside the model.

        Args:
            uri: `name://path` or `file:///path`; that of a xacro file may end with arguments, such as `?arm=left`.

        Raises:
            ModelNotFound: The model is missing or too large, or the path leaves its folder.
        """
        # `urlsplit` rejects names with underscores.
        name, separator, rest = uri.partition("://")
        if not separator or not name or not rest:
            raise ModelNotFound(f"invalid model '{uri}': expected `name://path`, or `file:///path` for a file")
        file, arguments = rest.partition(MARK)[::2]
        relative = unquote(f"{file}{SUFFIX}" if arguments else rest)
        if name == "file":
            path = self.locate(Path(relative))
            return self._gather(path, arguments, uri, None if self.locate is unchanged_path else (path.parent,))
        searched = []
        for root in self._roots(name):
            path = (root / relative).resolve()
            if not path.is_relative_to(root.resolve()):
                raise ModelNotFound(f"'{uri}' leads out of the folder of its models")
            if path.is_file():
                return self._gather(path, arguments, uri, (*self.folders, root))
            searched.append(str(path))
        places = ", ".join(searched)
        raise ModelNotFound(f"unknown model '{uri}' (searched: {places}; `--model-path` adds folders)")

    def _gather(self, path: Path, arguments: str, uri: str, within: Sequence[Path] | None) -> ModelFiles:
        named = Path(f"{path}?{arguments}") if arguments else path
        try:
            return gather(named, within, expands=self.expands)
        except InvalidModel as error:
            raise ModelNotFound(f"cannot read the model '{uri}': {error}") from error

    def files(self, suffixes: Container[str]) -> Iterator[tuple[str, Path]]:
        """Yield all files that `read` finds and that have one of some suffixes, each with its URI."""
        for name in dict.fromkeys(self._names()):
            seen: set[str] = set()
            for root in self._roots(name):
                for path in files_in(root, suffixes):
                    relative = path.relative_to(root).as_posix()
                    if relative not in seen:
                        seen.add(relative)
                        yield f"{name}://{quote(relative)}", path

    def _names(self) -> Iterator[str]:
        """Yield the names of folders and packages with models."""
        for folder in (*self.folders, OWN_MODELS):
            if folder.is_dir():
                yield from sorted(path.name for path in folder.iterdir() if path.is_dir())
        yield from sorted(name for name, _ in _packages(tuple(sys.path)))

    def _roots(self, name: str) -> Iterator[Path]:
        for folder in self.folders:
            yield folder / name
        for module in (module for named, module in _packages(tuple(sys.path)) if named == name):
            spec = find_spec(module)
            if spec is not None and spec.origin is not None:
                yield Path(spec.origin).parent
        yield OWN_MODELS / name


@cache
def _packages(path: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return the names and modules of packages with models; looking for them takes 10 ms, as much as a short run.

    Args:
        path: Search path of modules, which decides about the packages.
    """
    return tuple((entry.name, entry.module) for entry in entry_points(group="seoro.models"))


def files_in(folder: Path, suffixes: Container[str]) -> Iterator[Path]:
    """Yield the files in and below a folder with one of some suffixes, sorted; no links out of the folder."""
    if not folder.is_dir():
        return
    root = folder.resolve()
    for path in sorted(folder.rglob("*")):
        if path.suffix in suffixes and path.is_file() and path.resolve().is_relative_to(root):
            yield path
