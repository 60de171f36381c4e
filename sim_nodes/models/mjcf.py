"""MJCF files as one text with its assets, for MuJoCo's compiler.

Included files are inserted, and assets get short names without folders. So MuJoCo reads nothing from disk, and the
text means the same on every machine.
"""

from __future__ import annotations

import posixpath
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any
from xml.etree.ElementTree import tostring

from seoro.bridges.model_files import virtual_path
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import Mjcf

MAX_INCLUDES = 20  # nested
FILES = ("file", "fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
FOLDERS = {
    "mesh": "meshdir",
    "skin": "meshdir",
    "hfield": "meshdir",
    "flexcomp": "meshdir",
    "texture": "texturedir",
}


def bundle_mjcf(root: Any, files: Mapping[str, bytes]) -> Mjcf:
    """Return an MJCF file with its includes and assets.

    Args:
        root: Root element, which is changed.
        files: Files of the model by virtual path.

    Raises:
        RequestRefused: A file is missing, or includes are nested too deep.
    """
    _include(root, files, "", MAX_INCLUDES)
    folders = _folders(root)
    assets: dict[str, bytes] = {}
    names: dict[str, str] = {}
    for element in root.iter():
        for key in FILES:
            if (named := element.get(key)) is None or element.tag not in FOLDERS:
                continue
            path = virtual_path(named, folders[FOLDERS[element.tag]])
            if path not in files:
                raise xml.invalid(f"missing file {named!r} of {xml.label(element)}; expected it beside the model")
            if path not in names:
                names[path] = f"asset{len(names)}{PurePosixPath(path).suffix.lower()}"
                assets[names[path]] = files[path]
            if key == "file" and element.get("name") is None:
                element.set("name", PurePosixPath(path).stem)  # as MuJoCo names assets
            element.set(key, names[path])
    return Mjcf(tostring(root, encoding="unicode"), assets)


def _include(element: Any, files: Mapping[str, bytes], folder: str, depth: int) -> None:
    """Replace the <include> elements in an element by the content of their files."""
    if not depth:
        raise xml.invalid(f"files include each other more than {MAX_INCLUDES} times")
    for child in list(element):
        if child.tag != "include":
            _include(child, files, folder, depth)
            continue
        path = virtual_path(child.get("file", ""), folder)
        if path not in files:
            raise xml.invalid(f"missing file {child.get('file')!r} of <include>; expected it beside the model")
        content = xml.parse_xml(files[path].decode("utf-8", "replace"))
        _include(content, files, folder, depth - 1)
        index = list(element).index(child)
        element.remove(child)
        for offset, inserted in enumerate(content):
            element.insert(index + offset, inserted)


def _folders(root: Any) -> dict[str, str]:
    """Return the virtual folders of meshes and textures, and remove them from the model."""
    found = {"meshdir": "", "texturedir": ""}
    for compiler in root.iter("compiler"):
        both = compiler.attrib.pop("assetdir", None)
        for key in found:
            own = compiler.attrib.pop(key, both)
            if own is not None:
                found[key] = posixpath.normpath(own)
        compiler.attrib.pop("strippath", None)
    return found
