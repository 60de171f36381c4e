"""Where definitions come from: the packages that seoro brings, and folders of users.

seoro's own are files `data/DISTRIBUTION/PACKAGE.interfaces`, one for each package: the lines of all its .msg, .srv
and .action files without comments, each under a heading such as `[msg/Point]`. `packing.py` makes them. Packages
that change more often than distributions have further files, `data/editions/PACKAGE-VERSION.interfaces`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.names import PARTS, is_interface_name, is_package_name
from seoro.errors import InvalidUse
from seoro.input_files import Kind, read_input_text

DATA: Final = Path(__file__).with_name("data")
_EDITIONS: Final = "editions"
MAX_FILES: Final = 20_000  # in the folder of a user


@dataclass(frozen=True)
class Source:
    """The text of one definition.

    Args:
        text: What a .msg, .srv or .action file has.
        origin: The file that has it.
        line: The number of its first line there.
    """

    text: str
    origin: str
    line: int = 1


class BundledPackage:
    """A file of seoro's with the definitions of a package, which is read when one of them is asked for.

    Args:
        file: The file.
    """

    def __init__(self, file: Path) -> None:
        self.origin = f"{file.parent.name}/{file.name} of seoro"
        self._file = file
        self._sources: Mapping[str, Source] | None = None

    def interfaces(self) -> tuple[str, ...]:
        """What it defines, sorted."""
        return tuple(sorted(self._read()))

    def source(self, interface: str) -> Source | None:
        """The definition of such a name, if there is one."""
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
    """A package of a user, whose files are read when they are asked for.

    Args:
        folder: The package.
        files: Its files by what they define, such as `msg/Point`.
    """

    def __init__(self, folder: Path, files: Mapping[str, Path]) -> None:
        self.origin = str(folder)
        self._files = files

    def interfaces(self) -> tuple[str, ...]:
        """What it defines, sorted."""
        return tuple(sorted(self._files))

    def source(self, interface: str) -> Source | None:
        """The definition of such a name, if there is one."""
        file = self._files.get(interface)
        if file is None:
            return None
        try:
            return Source(read_input_text(file, Kind.DEFINITION), str(file))
        except UnicodeDecodeError:
            raise InvalidDefinition(f"{file}: no text in UTF-8") from None
        except OSError as error:
            raise InvalidDefinition(f"{file}: cannot be read: {error.strerror}") from None


class ToldPackage:
    """Definitions that a robot has told, and others of the same package.

    Args:
        sources: What it has told, by what it defines, such as `msg/Point`.
        others: The package from which the others are, if it is known.
        origin: Who has told it.
    """

    def __init__(self, sources: Mapping[str, Source], others: Package | None, origin: str) -> None:
        self.origin = origin
        self._sources = sources
        self._others = others

    def interfaces(self) -> tuple[str, ...]:
        """What it defines, sorted."""
        others = () if self._others is None else self._others.interfaces()
        return tuple(sorted({*self._sources, *others}))

    def source(self, interface: str) -> Source | None:
        """The definition of such a name, if there is one."""
        told = self._sources.get(interface)
        return self._others.source(interface) if told is None and self._others is not None else told


Package: TypeAlias = BundledPackage | PackageFolder | ToldPackage


def bundled_packages(distribution: str) -> dict[str, Package]:
    """The packages that seoro has of a distribution of ROS 2, by name.

    Raises:
        InvalidUse: seoro has none of that distribution.
    """
    known = sorted(folder.name for folder in DATA.iterdir() if folder.is_dir() and folder.name != _EDITIONS)
    if distribution not in known:
        raise InvalidUse(
            f"no interfaces of ROS 2 {distribution!r} come with seoro",
            help=f"there are those of {', '.join(known)}; for others, add a folder with their packages",
        )
    return {file.stem: BundledPackage(file) for file in (DATA / distribution).glob("*.interfaces")}


def editions(package: str) -> tuple[Package, ...]:
    """All that seoro has of a package, of all distributions and versions."""
    files = (*DATA.glob(f"*/{package}.interfaces"), *DATA.glob(f"{_EDITIONS}/{package}-*.interfaces"))
    return tuple(BundledPackage(file) for file in sorted(files))


def packages_in(folder: Path) -> dict[str, Package]:
    """The packages of a folder of a user, by name.

    Args:
        folder: Has `PACKAGE/msg/X.msg`, `PACKAGE/srv/X.srv` and `PACKAGE/action/X.action`.

    Raises:
        InvalidUse: There is no such folder, or no interface in it.
        InvalidDefinition: A package or a file has a name that ROS 2 does not have.
    """
    if not folder.is_dir():
        raise InvalidUse(f"{folder}: there is no such folder with packages of interfaces")
    files: dict[str, dict[str, Path]] = {}
    count = 0
    for kind in PARTS:
        for file in folder.glob(f"*/{kind}/*.{kind}"):
            count += 1
            if count > MAX_FILES:
                raise InvalidUse(f"{folder}: more than {MAX_FILES} interfaces are too many")
            package = file.parent.parent.name
            if not is_package_name(package) or not is_interface_name(file.stem):
                raise InvalidDefinition(
                    f"{file}: no name of ROS 2",
                    help="packages are written like_this, with letters and digits, and interfaces LikeThis",
                )
            files.setdefault(package, {})[f"{kind}/{file.stem}"] = file
    if not files:
        raise InvalidUse(
            f"{folder}: no interfaces found",
            help=f"expected {folder}/PACKAGE/msg/NAME.msg, or srv/NAME.srv, or action/NAME.action in a package"
            + f"; this is a package, so give {folder.parent}" * any((folder / kind).is_dir() for kind in PARTS),
        )
    return {package: PackageFolder(folder / package, found) for package, found in files.items()}
