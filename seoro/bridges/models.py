"""Finding models by name: `name://path`, along the model path.

The model path is: folders given by the user, in their order, each with a folder `name`; then what installed
packages register in the entry-point group `seoro.models` (`name = "package.module"`, whose folder is that of
`name`); then seoro's own models. `file://` names a file directly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote

MAX_MODEL_SIZE = 4 * 1024 * 1024  # [bytes]
OWN_MODELS = Path(__file__).resolve().parent.parent / "models"


class ModelNotFound(Exception):
    """No model by that name; the message says where was looked."""


@dataclass(frozen=True)
class ModelPath:
    """Where models are looked up.

    Args:
        folders: Given by the user; looked at first.
    """

    folders: Sequence[Path] = ()

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
            return _read(Path(relative), uri)
        looked = []
        for root in self._roots(name):
            path = (root / relative).resolve()
            if not path.is_relative_to(root.resolve()):
                raise ModelNotFound(f"'{uri}' leaves the folder of its models")
            if path.is_file():
                return _read(path, uri)
            looked.append(str(path))
        raise ModelNotFound(f"there is no model '{uri}'; looked at {', '.join(looked)}")

    def _roots(self, name: str) -> Iterator[Path]:
        for folder in self.folders:
            yield folder / name
        for entry in entry_points(group="seoro.models", name=name):
            spec = find_spec(entry.module)
            if spec is not None and spec.origin is not None:
                yield Path(spec.origin).parent
        yield OWN_MODELS / name


def _read(path: Path, uri: str) -> str:
    try:
        if path.stat().st_size > MAX_MODEL_SIZE:
            raise ModelNotFound(f"the model '{uri}' is larger than {MAX_MODEL_SIZE} bytes")
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ModelNotFound(f"the model '{uri}' cannot be read: {error}") from error
