"""Packing of a scenario into a bundle, with all files that it reads.

The files of a bundle keep their relative positions below their common parent folder, since scenario files import
each other by relative paths.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges.executor import messages as wire
from seoro.bundle.file_references import ReferencedFiles, referenced_files
from seoro.bundle.paths import ROOT, InvalidPath, check_path, is_world_name
from seoro.bundle.worlds import file_here, files_of_foreign_world, files_of_world, is_file_uri, is_world_file
from seoro.embed.options import ROS_SIMULATOR, Lab, Options, Ros, Simulator
from seoro.embed.parameter_files import read_parameters
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.time_limit import PROGRAM_LIMIT, Source, WallLimit
from seoro.embed.video import VideoOptions
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.files.world_names import WorldName
from seoro.lang import ast
from seoro.lang.libraries import FOLDER, Origin, folder_around
from seoro.lang.loader import Sources, path_of
from seoro.lang.lower.lower import find_entry
from seoro.lang.projects import project_of

if TYPE_CHECKING:
    from seoro.lab.reading import Lab as ReadLab

_CACHES: Final = frozenset({"__pycache__"})  # folders that are not packed


@dataclass(frozen=True)
class Bundle:
    """Bundle with blobs on this machine.

    Args:
        manifest: Manifest.
        blobs: Files by the hash of their content.
        names_absolute: Whether some files name others by absolute paths.
    """

    manifest: wire.Manifest
    blobs: dict[str, Path]
    names_absolute: bool = False


def pack(
    scenario: Scenario,
    options: Options,
    limit: WallLimit = PROGRAM_LIMIT,
    contents: Path | None = None,
    film: VideoOptions | None = None,
) -> Bundle:
    """Make a bundle.

    Args:
        scenario: Result of `load`.
        options: Options of the run; observers and the output folder are not sent.
        limit: Limit of the wall time.
        contents: File with the text of the scenario, if it was not read from its own file.
        film: Video to record.

    Raises:
        UsageError: A required file cannot be sent, or the bundle is too large.
    """
    sources = scenario.checked.sources
    entry = sources.entry.file.path
    if entry is None or not (contents or entry).is_file():
        raise UsageError(f"cannot send {sources.entry.file.name}: not a file", help="save the scenario in a file")
    if options.parameters is not None:  # reports its errors
        read_parameters(options.parameters, find_entry(scenario.checked, options.name).qualified_name)
    folders = _folders(options)
    sent = _files_of(scenario, options, entry.parent)
    lab = _lab_of(options)
    files = [*_single_files(options), *_world_files(options, lab), *sent.paths]
    names_absolute = sent.is_absolute or (lab is not None and _world_is_absolute(lab))
    if lab is not None and lab.bag is not None:
        files += [*_bag_files(lab, lab.bag), *_profile_files(lab)]
    for path in () if lab is None else _resets(lab):
        reset = check_file(path, import_python=False).without_errors()
        of_reset = _files_of(reset, Options(), path.parent)
        files += of_reset.paths
        names_absolute |= of_reset.is_absolute
    for folder in folders:
        files += _files_below(folder)
    absolute = sorted({Path(os.path.abspath(file)) for file in files})  # noqa: PTH100 - links keep their names
    parents = [str(file.parent) for file in absolute]
    here = Path.cwd()
    if not Path(sources.entry.file.name).is_absolute():  # other relative paths refer to the working directory
        parents.append(str(here))
    root = Path(os.path.commonpath([*parents, *(os.path.abspath(folder) for folder in folders)]))  # noqa: PTH100
    packer = _Packer(root, {} if contents is None else {Path(os.path.abspath(entry)): contents})  # noqa: PTH100
    listed = tuple(packer.add(file) for file in absolute)
    if (total := sum(file.size for file in listed)) > wire.MAX_BUNDLE:
        raise UsageError(
            f"the files of the scenario are too large: {total >> 20} MiB, limit {wire.MAX_BUNDLE >> 20} MiB"
        )
    manifest = wire.Manifest(
        files=listed,
        entry=packer.place(entry),
        shown=sources.entry.file.name,
        directory=packer.place(here) if here.is_relative_to(root) and here != root else ROOT,
        root=str(root),
        options=_bundled(options, packer, limit, film),
    )
    return Bundle(manifest, packer.blobs, names_absolute)


class _Packer:
    """Maps files to their paths in a bundle."""

    def __init__(self, root: Path, elsewhere: Mapping[Path, Path]) -> None:
        self._root = root
        self._elsewhere = elsewhere  # files with the content of others
        self.blobs: dict[str, Path] = {}

    def place(self, path: Path) -> str:
        """Return the path of a file or a folder in the bundle."""
        return Path(os.path.abspath(path)).relative_to(self._root).as_posix()  # noqa: PTH100 - as above

    def add(self, path: Path) -> wire.BundleFile:
        """Add a file; return its entry in the manifest."""
        try:
            check_path(self.place(path))
            source = self._elsewhere.get(path, path)
            with open_input(source, Kind.BUNDLED) as stream:
                size = os.fstat(stream.fileno()).st_size
                if size > wire.MAX_FILE:
                    raise UsageError(f"{path} is too large: {size >> 20} MiB, limit {wire.MAX_FILE >> 20} MiB")
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
        except InvalidPath as error:
            raise UsageError(f"cannot send {path}: {error}", help="rename it") from error
        except OSError as error:
            raise UsageError(f"cannot read {path}: {error.strerror}") from error
        self.blobs[digest] = source
        return wire.BundleFile(path=self.place(path), hash=digest, size=size)


# ---------------------------------------------------------------- files


def _lab_of(options: Options) -> ReadLab | None:
    """Read the lab file, if any."""
    if options.lab is None:
        return None
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

    return read_lab(options.lab.file)


def _check_relative(what: str, robot: str, path: str | None) -> None:
    """Check that a path in a lab file is relative.

    Args:
        what: Owner of the path, in words.
        robot: Name of the robot in the lab file.
        path: The path, if there is one.
    """
    if Path(path or "").is_absolute():
        raise UsageError(
            f"the {what} of `{robot}` has an absolute path, {path}, which the executor does not have",
            help="use a path relative to the lab file",
        )


def _bag_files(lab: ReadLab, bag: Path) -> Iterable[Path]:
    """Return the files of the bag of recorded robots."""
    for name, robot in lab.robots.items():
        _check_relative("bag", name, robot.bag)
    return _files_below(bag) if bag.is_dir() else [bag]


def _profile_files(lab: ReadLab) -> Iterator[Path]:
    """Yield the profiles of recorded robots that are files."""
    for name, robot in lab.robots.items():
        _check_relative("profile", name, robot.profile)
        if isinstance(profile := lab.profile_of(name), Path):
            yield profile


def _resets(lab: ReadLab) -> Iterator[Path]:
    """Yield the reset scenarios of a lab."""
    for name, robot in lab.robots.items():
        _check_relative("reset scenario", name, None if robot.after is None else robot.after.scenario)
    yield from {path: None for robot in lab.robots if (path := lab.reset_of(robot)) is not None}


def _files_of(scenario: Scenario, options: Options, folder: Path) -> ReferencedFiles:
    """Return all files of a scenario in a folder."""
    sources = scenario.checked.sources
    files, is_absolute = [*_own_sources(sources)], _imports_absolute(sources)
    for named in referenced_files(scenario, options, folder):
        is_absolute |= named.is_absolute
        for path in named.paths:
            files += _files_below(path) if path.is_dir() else [path]
    for library in _library_folders(sources):
        files += _files_below(library)
    files += _project_files(sources)
    return ReferencedFiles(files, is_absolute)


def _own_sources(sources: Sources) -> Iterator[Path]:
    """Yield the scenario files that are not part of seoro or an installed package."""
    origins = {library.name: library.origin for library in sources.libraries}
    for module in sources.modules:
        if module.library is not None and origins[module.library] is not Origin.BESIDE:
            continue
        if module.file.path is not None:
            yield module.file.path


def _imports_absolute(sources: Sources) -> bool:
    """Return whether a file is imported by an absolute path."""
    statements = (statement for module in sources.modules for statement in module.tree.statements)
    paths = (path_of(statement.uri) for statement in statements if isinstance(statement, ast.ImportUri))
    return any(path is not None and path.is_absolute() for path in paths)


def _library_folders(sources: Sources) -> Iterator[Path]:
    """Yield the folders of libraries beside the scenario, since their Python may use all files there."""
    for library in sources.libraries:
        if library.origin is Origin.BESIDE:
            yield folder_around(library.path) or library.path.parent


def _project_files(sources: Sources) -> Iterator[Path]:
    """Yield the settings of the project if they name the folder of a library."""
    for folder in _library_folders(sources):
        if folder.name != FOLDER and (project := project_of(folder)) is not None:
            yield project.file


def _single_files(options: Options) -> Iterator[Path]:
    if options.parameters is not None:
        yield options.parameters
    if options.simulator is not None and options.simulator.snapshot is not None:
        yield options.simulator.snapshot
    if options.lab is not None:
        yield options.lab.file


def _world_files(options: Options, lab: ReadLab | None) -> Iterator[Path]:
    """Yield the files of the world, if it is a file of the user."""
    world = options.simulator.world if options.simulator is not None else None
    if options.simulator is not None and options.simulator.name == ROS_SIMULATOR:
        if world is not None and (file := file_here(world)) is not None:
            yield from files_of_foreign_world(file)
        return
    if lab is not None:
        world = lab.world
    if world is None or is_world_name(world):
        return
    if not is_world_file(world):
        raise UsageError(
            f"invalid world '{world}': expected the name of a world, or a world file",
            help="name a world of the executor's simulators, such as `maze`, or a file such as `hall.yaml`",
        )
    yield from files_of_world(world)


def _world_is_absolute(lab: ReadLab) -> bool:
    """Return whether the lab names a world file by an absolute path."""
    return lab.simulator is not None and Path(lab.simulator[1].world or "").is_absolute()


def _folders(options: Options) -> Sequence[Path]:
    """Return the folders that the options name."""
    named: list[Path] = []
    if options.simulator is not None:
        named += options.simulator.model_path
    if options.lab is not None:
        named += options.lab.model_path
    if options.ros is not None:
        named += options.ros.interfaces
    for folder in named:
        if not folder.is_dir():
            raise UsageError(f"folder not found: {folder}")
        if next(_files_below(folder), None) is None:
            raise UsageError(f"empty folder: {folder}")
    return named


def _files_below(folder: Path) -> Iterator[Path]:
    """Yield the files below a folder, except hidden ones and caches."""
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name not in _CACHES)
        yield from (Path(place, name) for name in sorted(files) if not name.startswith("."))


# ---------------------------------------------------------------- options


def _bundled(
    options: Options, packer: _Packer, limit: WallLimit, film: VideoOptions | None
) -> wire.BundledOptions:
    return wire.BundledOptions(
        name=options.name,
        seed=options.seed,
        overrides=dict(options.overrides),
        parameters=None if options.parameters is None else packer.place(options.parameters),
        constraints=tuple(options.constraints),
        clock=options.clock,
        simulator=None if options.simulator is None else _simulator(options.simulator, packer),
        ros=None if options.ros is None else _ros(options.ros, packer),
        lab=None if options.lab is None else _lab(options.lab, packer),
        leasing=wire.BundledLeasing(
            wait=options.leasing.wait, priority=options.leasing.priority, lease=options.leasing.lease
        ),
        grace=options.grace,
        timeout=None if limit.source is Source.DEFAULT else limit.seconds,
        timeout_of_file=limit.source is Source.FILE,
        poses=options.poses,
        scans=options.scans,
        external=tuple(options.external),
        film=None if film is None else wire.BundledFilm(**asdict(film)),
    )


def _simulator(given: Simulator, packer: _Packer) -> wire.BundledSimulator:
    file: Path | None = None
    parameters = ""
    if given.world is not None:
        if given.name == ROS_SIMULATOR:
            file = file_here(given.world)
        elif is_world_file(given.world):
            name = WorldName.parse(given.world)
            file, parameters = Path(name.world), name.parameters
    return wire.BundledSimulator(
        name=given.name,
        endpoint=given.endpoint,
        world=given.world if file is None else None,
        world_file=None if file is None else packer.place(file),
        world_parameters=parameters or None,
        world_by_uri=file is not None and given.world is not None and is_file_uri(given.world),
        rate=given.rate,
        model_path=_places(given.model_path, packer),
        snapshot=None if given.snapshot is None else packer.place(given.snapshot),
    )


def _ros(given: Ros, packer: _Packer) -> wire.BundledRos:
    return wire.BundledRos(
        endpoint=given.endpoint,
        domain=given.domain,
        dialect=given.dialect,
        interfaces=_places(given.interfaces, packer),
    )


def _lab(given: Lab, packer: _Packer) -> wire.BundledLab:
    return wire.BundledLab(
        file=packer.place(given.file), rate=given.rate, model_path=_places(given.model_path, packer)
    )


def _places(folders: Iterable[Path], packer: _Packer) -> tuple[str, ...]:
    return tuple(packer.place(folder) for folder in folders)
