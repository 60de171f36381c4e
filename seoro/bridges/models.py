"""Finding models by name: `name://path`, along the model path.

The model path is: folders given by the user, in their order, each with a folder `name`; then what installed
packages register in the entry-point group `seoro.models` (`name = "package.module"`, whose folder is that of
`name`); then seoro's own models. `file://` names a file directly.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import quote, unquote

from seoro.input_files import Kind, read_input_text
from seoro.located import Locate, as_named

OWN_MODELS = Path(__file__).resolve().parent.parent / "models"


class ModelNotFound(Exception):
    """No model by that name; the message says where was looked."""


@dataclass(frozen=True)
class ModelPath:
    """Where models are looked up.

    Args:
        folders: Given by the user; looked at first.
        locate: Gives the places of files that are named by absolute paths.
    """

    folders: Sequence[Path] = ()
    locate: Locate = as_named

    def read(self, uri: str) -> str:
        """The text of a model.

        Args:
            uri: `name://path` or `file:///path`.

        Raises:
            ModelNotFound: There is none, it is too large, or the path leaves its folder.
        """
        # Not urlsplit: names may hold underscores, which schemes of URIs must not.
        name, separator, rest = uri.partition("://")
        if not separator or not name or not rest:
            raise ModelNotFound(f"'{uri}' names no model: write `name://path`, or `file:///path` for a file")
        relative = unquote(rest)
        if name == "file":
            return _read(self.locate(Path(relative)), uri)
        looked = []
        for root in self._roots(name):
            path = (root / relative).resolve()
            if not path.is_relative_to(root.resolve()):
                raise ModelNotFound(f"'{uri}' leaves the folder of its models")
            if path.is_file():
                return _read(path, uri)
            looked.append(str(path))
        raise ModelNotFound(f"there is no model '{uri}'; looked at {', '.join(looked)}")

    def files(self, suffixes: Container[str]) -> Iterator[tuple[str, Path]]:
        """All files with one of some suffixes, each after the URI by which `read` finds it, and no other first."""
        for name in dict.fromkeys(self._names()):
            seen: set[str] = set()
            for root in self._roots(name):
                for path in files_in(root, suffixes):
                    relative = path.relative_to(root).as_posix()
                    if relative not in seen:
                        seen.add(relative)
                        yield f"{name}://{quote(relative)}", path

    def _names(self) -> Iterator[str]:
        """Names that there may be models by."""
        for folder in (*self.folders, OWN_MODELS):
            if folder.is_dir():
                yield from sorted(each.name for each in folder.iterdir() if each.is_dir())
        yield from sorted(entry_points(group="seoro.models").names)

    def _roots(self, name: str) -> Iterator[Path]:
        for folder in self.folders:
            yield folder / name
        for entry in entry_points(group="seoro.models", name=name):
            spec = find_spec(entry.module)
            if spec is not None and spec.origin is not None:
                yield Path(spec.origin).parent
        yield OWN_MODELS / name


def files_in(folder: Path, suffixes: Container[str]) -> Iterator[Path]:
    """The files in and below a folder that have one of some suffixes, sorted; none that links lead out to."""
    if not folder.is_dir():
        return
    home = folder.resolve()
    for path in sorted(folder.rglob("*")):
        if path.suffix in suffixes and path.is_file() and path.resolve().is_relative_to(home):
            yield path


def _read(path: Path, uri: str) -> str:
    try:
        return read_input_text(path, Kind.MODEL)
    except (OSError, UnicodeDecodeError) as error:
        raise ModelNotFound(f"the model '{uri}' cannot be read: {error}") from error
