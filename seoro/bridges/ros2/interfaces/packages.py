"""Packages of interface definitions: packages of seoro, and folders of users.

Packages of seoro are files `data/DISTRIBUTION/PACKAGE.interfaces`, made by `packing.py`. They contain the lines of
all .msg, .srv and .action files without comments, each file under a heading such as `[msg/Point]`. Packages that
change more often than distributions have further files, `data/editions/PACKAGE-VERSION.interfaces`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Final

from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.names import PARTS, is_interface_name, is_package_name
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input_text

DATA: Final = Path(__file__).with_name("data")
_EDITIONS: Final = "editions"
_EXTENDED: Final = {"nav_msgs": "nav_msgs-kilted.interfaces"}  # all interfaces of before, and further ones
MAX_FILES: Final = 20_000  # in a folder of a user


@dataclass(frozen=True)
class Source:
    """Source text of a definition.

    Args:
        text: Text of a .msg, .srv or .action file.
        origin: File that contains the text.
        line: Number of its first line in the file.
    """

    text: str
    origin: str
    line: int = 1


class Package:
    """A package of interfaces, whose definitions are read on first use.

    Args:
        origin: File, folder or node with the definitions, in error messages.
        read: Returns the definitions, or their files, by the names of interfaces, such as `msg/Point`.
    """

    def __init__(self, origin: str, read: Callable[[], Mapping[str, Source | Path]]) -> None:
        self.origin = origin
        self.sources = cache(read)

    def interfaces(self) -> tuple[str, ...]:
        """Return the names of the interfaces, sorted."""
        return tuple(sorted(self.sources()))

    def source(self, interface: str) -> Source | None:
        """Return the definition of an interface, if the package has it."""
        found = self.sources().get(interface)
        return _read_source(found) if isinstance(found, Path) else found


def _read_source(file: Path) -> Source:
    try:
        return Source(read_input_text(file, Kind.DEFINITION), str(file))
    except UnicodeDecodeError:
        raise InvalidDefinition(f"{file}: expected UTF-8 text") from None
    except OSError as error:
        raise InvalidDefinition(f"cannot read {file}: {error.strerror}") from None


def bundled_package(file: Path) -> Package:
    """Return a package that comes with seoro, from the file with its definitions."""
    origin = f"{file.parent.name}/{file.name} of seoro"
    return Package(origin, partial(_read_sections, file, origin))


def _read_sections(file: Path, origin: str) -> Mapping[str, Source]:
    head, *sections = file.read_text(encoding="utf-8").split("\n[")
    line = 2 + head.count("\n")
    sources: dict[str, Source] = {}
    for section in sections:
        heading, _, text = section.partition("]\n")
        sources[heading] = Source(text, origin, line + 1)
        line += 1 + section.count("\n")
    return sources


def remote_package(sources: Mapping[str, Source], others: Package | None, origin: str) -> Package:
    """Return a package with definitions fetched from a robot.

    Args:
        sources: Fetched definitions by the names of interfaces, such as `msg/Point`.
        others: Package with the other definitions, if known.
        origin: Node that has sent the definitions.
    """
    return Package(origin, lambda: sources if others is None else {**others.sources(), **sources})


def bundled_packages(distribution: str) -> dict[str, Package]:
    """Return the packages of a ROS 2 distribution that come with seoro, by name.

    Raises:
        UsageError: The distribution is unknown.
    """
    known = sorted(folder.name for folder in DATA.iterdir() if folder.is_dir() and folder.name != _EDITIONS)
    if distribution not in known:
        raise UsageError(
            f"unknown distribution {distribution!r} of interfaces (distributions: {', '.join(known)})",
            help="for another distribution, add a folder with its packages",
        )
    return {file.stem: bundled_package(file) for file in (DATA / distribution).glob("*.interfaces")}


def editions(package: str) -> tuple[Mapping[str, Package], ...]:
    """Return all editions of a package that come with seoro, each with the packages that it refers to.

    They are those of all distributions and versions.
    """
    files = (*DATA.glob(f"*/{package}.interfaces"), *DATA.glob(f"{_EDITIONS}/{package}-*.interfaces"))
    return tuple({**_extended(), package: bundled_package(file)} for file in sorted(files))


@cache
def _extended() -> Mapping[str, Package]:
    return {name: bundled_package(DATA / _EDITIONS / file) for name, file in _EXTENDED.items()}


def packages_in(folder: Path) -> dict[str, Package]:
    """Return the packages in a folder of a user, by name.

    Args:
        folder: Folder with `PACKAGE/msg/X.msg`, `PACKAGE/srv/X.srv` and `PACKAGE/action/X.action`.

    Raises:
        UsageError: The folder is missing, or contains no interface.
        InvalidDefinition: The name of a package or file is invalid in ROS 2.
    """
    if not folder.is_dir():
        raise UsageError(f"folder of interface packages not found: {folder}")
    files: dict[str, dict[str, Path]] = {}
    count = 0
    for kind in PARTS:
        for file in folder.glob(f"*/{kind}/*.{kind}"):
            count += 1
            if count > MAX_FILES:
                raise UsageError(f"{folder}: too many interfaces (limit: {MAX_FILES})")
            package = file.parent.parent.name
            if not is_package_name(package) or not is_interface_name(file.stem):
                raise InvalidDefinition(
                    f"{file}: invalid name of a package or interface",
                    help="names of packages are written like_this, names of interfaces LikeThis",
                )
            files.setdefault(package, {})[f"{kind}/{file.stem}"] = file
    if not files:
        raise UsageError(
            f"{folder}: no interfaces found",
            help=f"expected {folder}/PACKAGE/msg/NAME.msg, or srv/NAME.srv, or action/NAME.action in a package"
            + f"; this is a package, so give {folder.parent}" * any((folder / kind).is_dir() for kind in PARTS),
        )
    return {package: Package(str(folder / package), partial(dict, found)) for package, found in files.items()}
