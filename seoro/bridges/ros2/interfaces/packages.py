"""Packages of interface definitions: packages of seoro, and folders of users.

Packages of seoro are files `data/DISTRIBUTION/PACKAGE.interfaces`, made by `packing.py`. They contain the lines of
all .msg, .srv and .action files without comments, each file under a heading such as `[msg/Point]`. Packages that
change more often than distributions have further files, `data/editions/PACKAGE-VERSION.interfaces`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.names import PARTS, is_interface_name, is_package_name
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input_text

DATA: Final = Path(__file__).with_name("data")
_EDITIONS: Final = "editions"
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


class BundledPackage:
    """A package that comes with seoro, read on first use.

    Args:
        file: File with the definitions.
    """

    def __init__(self, file: Path) -> None:
        self.origin = f"{file.parent.name}/{file.name} of seoro"
        self._file = file
        self._sources: Mapping[str, Source] | None = None

    def interfaces(self) -> tuple[str, ...]:
        """Return the names of the interfaces, sorted."""
        return tuple(sorted(self._read()))

    def source(self, interface: str) -> Source | None:
        """Return the definition of an interface, if the package has it."""
        return self._read().get(interface)

    def _read(self) -> Mapping[str, Source]:
        if self._sources is None:
            head, *sections = self._file.read_text(encoding="utf-8").split("\n[")
            line = 2 + head.count("\n")
            sources: dict[str, Source] = {}
            for section in sections:
                heading, _, text = section.partition("]\n")
                sources[heading] = Source(text, self.origin, line + 1)
                line += 1 + section.count("\n")
            self._sources = sources
        return self._sources


class PackageFolder:
    """A package of a user, whose files are read on first use.

    Args:
        folder: Folder of the package.
        files: Files by the names of interfaces, such as `msg/Point`.
    """

    def __init__(self, folder: Path, files: Mapping[str, Path]) -> None:
        self.origin = str(folder)
        self._files = files

    def interfaces(self) -> tuple[str, ...]:
        """Return the names of the interfaces, sorted."""
        return tuple(sorted(self._files))

    def source(self, interface: str) -> Source | None:
        """Return the definition of an interface, if the package has it."""
        file = self._files.get(interface)
        if file is None:
            return None
        try:
            return Source(read_input_text(file, Kind.DEFINITION), str(file))
        except UnicodeDecodeError:
            raise InvalidDefinition(f"{file}: expected UTF-8 text") from None
        except OSError as error:
            raise InvalidDefinition(f"cannot read {file}: {error.strerror}") from None


class RemotePackage:
    """A package with definitions fetched from a robot.

    Args:
        sources: Fetched definitions by the names of interfaces, such as `msg/Point`.
        others: Package with the other definitions, if known.
        origin: Node that has sent the definitions.
    """

    def __init__(self, sources: Mapping[str, Source], others: Package | None, origin: str) -> None:
        self.origin = origin
        self._sources = sources
        self._others = others

    def interfaces(self) -> tuple[str, ...]:
        """Return the names of the interfaces, sorted."""
        others = () if self._others is None else self._others.interfaces()
        return tuple(sorted({*self._sources, *others}))

    def source(self, interface: str) -> Source | None:
        """Return the definition of an interface, if the package has it."""
        fetched = self._sources.get(interface)
        return self._others.source(interface) if fetched is None and self._others is not None else fetched


Package: TypeAlias = BundledPackage | PackageFolder | RemotePackage


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
    return {file.stem: BundledPackage(file) for file in (DATA / distribution).glob("*.interfaces")}


def editions(package: str) -> tuple[Package, ...]:
    """Return all editions of a package that come with seoro, of all distributions and versions."""
    files = (*DATA.glob(f"*/{package}.interfaces"), *DATA.glob(f"{_EDITIONS}/{package}-*.interfaces"))
    return tuple(BundledPackage(file) for file in sorted(files))


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
    return {package: PackageFolder(folder / package, found) for package, found in files.items()}
