"""Model files (URDF, xacro, SDF, MJCF) with all files that they name: models, meshes, materials, textures.

Files have virtual paths, which are the same on every machine. A virtual path is relative to the model file, begins
with `package/NAME/` or `model/NAME/` for URIs of these schemes, or is absolute.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Final
from urllib.parse import unquote

from seoro.bridges.xacro_files import SUFFIX, InvalidXacro, expand, split_arguments
from seoro.deferred import dataclass
from seoro.files.inputs import Kind, failure_reason, read_input, read_input_text, resolved

MAX_FILES: Final = 2000
MAX_BYTES: Final = 256 << 20  # of all files of a model
ANCESTORS: Final = 6  # folders above a model in which packages are searched
SCHEMES: Final = ("package", "model")
XML: Final = frozenset({".urdf", ".sdf", ".world", ".xml", ".mjcf", ".xacro", ".config"})
PACKAGE_PATHS: Final = ("ROS_PACKAGE_PATH", "GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH", "SDF_PATH")  # of folders

_COMMENT: Final = re.compile(r"<!--.*?-->", re.DOTALL)
_NAMED: Final = re.compile(r"""\s(?:file\w*|filename|url)\s*=\s*["']([^"']+)["']|<(?:uri|albedo_map)>([^<]+)</""")
_COMPILER: Final = re.compile(r"<compiler\s[^>]*>")
_FOLDER: Final = re.compile(r"""\s(?:mesh|texture|asset)dir\s*=\s*["']([^"']*)["']""")
_MTLLIB: Final = re.compile(rb"^\s*mtllib\s+(.+?)\s*$", re.MULTILINE)
_MAP: Final = re.compile(
    rb"^\s*map_Kd\s+(?:-[a-z]\w*\s+(?:(?:-?[\d.]\S*|on|off)\s+)*)*(.+?)\s*$", re.MULTILINE
)  # options of OBJ come first
_PACKAGE: Final = re.compile(r"<name>([^<]+)</name>")
_IMAGE: Final = re.compile(rb"<init_from>([^<]+\.[A-Za-z]{3,4})</init_from>")


class InvalidModel(Exception):
    """A model file is unreadable, or a limit is exceeded."""


@dataclass(frozen=True)
class ModelFiles:
    """A model.

    Attributes:
        text: Text of the model file.
        files: Contents of the files that it names, by virtual path; missing ones are left out.
        paths: Paths of these files.
    """

    text: str
    files: Mapping[str, bytes] = field(default_factory=lambda: MappingProxyType({}))
    paths: tuple[Path, ...] = ()

    @property
    def size(self) -> int:
        """Size of all files [bytes]."""
        return len(self.text.encode()) + sum(map(len, self.files.values()))


def virtual_path(named: str, folder: str = "") -> str:
    """Return the virtual path of a file.

    Args:
        named: Name of the file in a model.
        folder: Virtual folder of the file that names it.
    """
    scheme, separator, rest = named.strip().partition("://")
    if separator and scheme == "file":
        return posixpath.normpath(unquote(rest))
    if separator:
        return posixpath.normpath(f"{scheme}/{unquote(rest)}")
    return posixpath.normpath(posixpath.join(folder, named.strip().replace("\\", "/")))


def gather(path: Path, within: Sequence[Path] | None = None, *, expands: bool = False) -> ModelFiles:
    """Read a model with all files that it names.

    Args:
        path: The model file; that of a xacro file may end with arguments, such as `?arm=left`.
        within: Folders that the named files must be in; None for any.
        expands: Whether a xacro file may be expanded, which evaluates expressions in it.

    Raises:
        InvalidModel: A file is unreadable, or the files are too many or too large.
    """
    try:
        named, arguments = split_arguments(str(path))
        if not named.endswith(SUFFIX):
            return _gather(path, read_input_text(path, Kind.MODEL), within)
        if not expands:
            raise InvalidModel(f"{path} is a xacro file, which only scenarios and world files name; expand it")
        return _gather_xacro(Path(named), arguments, within)
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidModel(f"cannot read {path}: {failure_reason(error)}") from error


def _gather_xacro(path: Path, arguments: Mapping[str, str], within: Sequence[Path] | None) -> ModelFiles:
    read_input_text(path, Kind.MODEL)  # of a suitable kind and size
    try:
        expanded = expand(path, arguments)
    except InvalidXacro as error:
        raise InvalidModel(f"cannot expand {path}: {error}") from error
    outside = [each for each in expanded.paths if not _is_within(each, within)]
    if outside:
        raise InvalidModel(f"{path} includes {outside[0]}, which is outside of the folders of models")
    found = _gather(path, expanded.text, within)
    return replace(found, paths=(*(each for each in expanded.paths if each != resolved(path)), *found.paths))


def _gather(path: Path, text: str, within: Sequence[Path] | None) -> ModelFiles:
    names, files, paths, size = _Names(), dict[str, bytes](), list[Path](), 0
    searched: set[str] = set()
    names.add_xml(text, "")
    while names.pending:
        name = names.pending.pop()
        if name in searched:
            continue
        searched.add(name)
        found = next((each for each in _candidates(name, path) if _is_readable(each, within)), None)
        if found is None:
            continue
        data = files[name] = read_input(found, Kind.MESH)
        paths.append(found)
        size += len(data)
        if len(files) > MAX_FILES or size > MAX_BYTES:
            raise InvalidModel(f"{path.name} names more than {MAX_FILES} files, or {MAX_BYTES >> 20} MiB")
        names.add(name, data)
    return ModelFiles(text, files, tuple(paths))


def _is_readable(path: Path, within: Sequence[Path] | None) -> bool:
    return path.is_file() and _is_within(path, within)


def _is_within(path: Path, folders: Sequence[Path] | None) -> bool:
    return folders is None or any(resolved(path).is_relative_to(resolved(folder)) for folder in folders)


class _Names:
    """Virtual paths that the names in the files of a model may stand for.

    Attributes:
        pending: Paths that were not searched yet, perhaps with repetitions.
    """

    def __init__(self) -> None:
        self.pending: list[str] = []
        self._texts: list[tuple[str, str]] = []  # of XML files, with their virtual folders
        self._folders: dict[str, None] = {}  # of the assets of MJCF, which one of its files sets for all

    def add(self, path: str, data: bytes) -> None:
        """Add the names in a file."""
        folder, suffix = posixpath.dirname(path), PurePosixPath(path).suffix.lower()
        if suffix in XML:
            self.add_xml(data.decode("utf-8", "replace"), folder)
        pattern = {".obj": _MTLLIB, ".mtl": _MAP, ".dae": _IMAGE}.get(suffix)
        if pattern is not None:
            named = (match[1].decode("utf-8", "replace") for match in pattern.finditer(data))
            self.pending += [virtual_path(name, folder) for name in named]

    def add_xml(self, text: str, folder: str) -> None:
        """Add the names in a model file, or in one that it includes."""
        text = _COMMENT.sub("", text)
        self._texts.append((text, folder))
        known = len(self._folders)
        self._folders |= dict.fromkeys(_asset_folders(text))
        for each in self._texts if len(self._folders) > known else self._texts[-1:]:
            self.pending += self._named_by(*each)

    def _named_by(self, text: str, folder: str) -> Iterator[str]:
        for match in _NAMED.finditer(text):
            name = match[1] or match[2]
            yield from dict.fromkeys(virtual_path(name, each) for each in (folder, "", *self._folders))
            if match[2] and "://" in name:
                model = virtual_path(name)
                yield from (f"{model}/model.config", f"{model}/model.sdf")


def _asset_folders(text: str) -> Iterator[str]:
    """Yield the virtual folders of meshes and textures that an MJCF file sets by `<compiler>`."""
    for tag in _COMPILER.findall(text):
        for match in _FOLDER.finditer(tag):
            yield virtual_path(match[1])


def _candidates(name: str, model: Path) -> Iterator[Path]:
    """Yield the paths at which a file may be, by its virtual path.

    Models may name files from a folder above, as PyBullet's do from its search path.
    """
    scheme, _, rest = name.partition("/")
    if scheme not in SCHEMES:
        yield model.parent / name
        yield model.parent / name.lstrip("/")
        yield from (folder / name for folder in _above(model)[1:])
        return
    package, _, inside = rest.partition("/")
    above = _above(model)
    for folder in (*above, *_search_path()):
        yield folder / package / inside
    for folder in above:
        yield folder / inside


def package_folder(name: str, model: Path) -> Path | None:
    """Return the folder of a package that a model names; None if it is missing.

    Packages are searched as for `package://NAME`. A folder above the model may have another name than its package.
    """
    above = _above(model)
    found = (folder / name for folder in (*above, *_search_path()))
    return next(
        (folder for folder in found if folder.is_dir()),
        next((folder for folder in above if _package_in(folder) == name), None),
    )


def _above(model: Path) -> list[Path]:
    return [model.parent, *model.parent.parents][:ANCESTORS]


def _package_in(folder: Path) -> str | None:
    """Return the name of the ROS package in a folder."""
    manifest = folder / "package.xml"
    if not manifest.is_file():
        return None
    found = _PACKAGE.search(read_input_text(manifest, Kind.MODEL))
    return None if found is None else found[1].strip()


def _search_path() -> Iterator[Path]:
    """Yield the folders of packages that environment variables of ROS and Gazebo name."""
    for variable in PACKAGE_PATHS:
        yield from (Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each)
    for each in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if each:
            yield Path(each) / "share"
