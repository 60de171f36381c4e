"""Unpacking of untrusted bundles into folders."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path, PurePosixPath

from seoro.bridges.executor import messages as wire
from seoro.bundle.paths import ROOT, InvalidPath, check_path, is_world_name
from seoro.embed.option_checks import check_options
from seoro.embed.options import ROS_SIMULATOR, ClockName, Lab, Leasing, Options, Ros, Simulator
from seoro.embed.time_limit import WallLimit, wall_limit
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.files.world_names import WorldName
from seoro.lab.reading import read_lab


class InvalidBundle(Exception):
    """The bundle was not made by a client of seoro."""


def check_manifest(manifest: wire.Manifest) -> None:
    """Check a manifest before the bundle is used.

    Raises:
        InvalidBundle: Paths lead out of the bundle or overlap, referenced files are missing, or it is too large.
    """
    try:
        places = {str(check_path(file.path)) for file in manifest.files}
        folders = {str(parent) for place in places for parent in PurePosixPath(place).parents}
        if manifest.directory != ROOT:
            check_path(manifest.directory)
    except InvalidPath as error:
        raise InvalidBundle(str(error)) from error
    if len(places) != len(manifest.files) or places & folders:
        raise InvalidBundle("two files of the bundle have the same path")
    if manifest.root is not None and not PurePosixPath(manifest.root).is_absolute():
        raise InvalidBundle(f"{manifest.root!r} is not an absolute path")
    options = manifest.options
    simulator, lab = options.simulator, options.lab
    world = simulator.world if simulator is not None else None
    if simulator is not None and simulator.name == ROS_SIMULATOR:
        if world is not None and not world.isprintable():
            raise InvalidBundle(f"invalid world {world!r}")
    elif world is not None and not is_world_name(world):
        raise InvalidBundle(f"{world!r} is not the name of a world")
    if sum(file.size for file in manifest.files) > wire.MAX_BUNDLE:
        raise InvalidBundle(f"the bundle is larger than {wire.MAX_BUNDLE >> 20} MiB")
    files = [manifest.entry, options.parameters, lab and lab.file]
    files += [simulator.snapshot, simulator.world_file] if simulator else []
    named = [*(simulator.model_path if simulator else ()), *(lab.model_path if lab else ())]
    named += options.ros.interfaces if options.ros else ()
    for file in files:
        if file is not None and file not in places:
            raise InvalidBundle(f"missing file {file!r} in the bundle")
    for folder in named:
        if folder not in folders:
            raise InvalidBundle(f"missing folder {folder!r} in the bundle")


def unpack(manifest: wire.Manifest, blob: Callable[[str], Path], folder: Path) -> None:
    """Write the files of a bundle. Files of equal content are hard links, shared by no other run.

    Args:
        manifest: Checked manifest.
        blob: Function that returns the file of a blob.
        folder: New folder for the files.

    Raises:
        InvalidBundle: The content of a blob differs from the manifest.
        OSError: A file cannot be written.
    """
    folder.mkdir(parents=True)
    first: dict[str, tuple[Path, int]] = {}  # by hash: first file with this content, and its size
    for file in manifest.files:
        path = folder / check_path(file.path)
        path.parent.mkdir(parents=True, exist_ok=True)
        if file.hash in first:
            _link(first[file.hash][0], path)
        else:
            shutil.copyfile(blob(file.hash), path)
            with path.open("rb") as stream:
                digest = hashlib.file_digest(stream, "sha256").hexdigest()
            if digest != file.hash:
                raise _other_content(file)
            first[file.hash] = path, path.stat().st_size
        if first[file.hash][1] != file.size:
            raise _other_content(file)
    (folder / manifest.directory).mkdir(parents=True, exist_ok=True)


def _link(there: Path, path: Path) -> None:
    try:
        path.hardlink_to(there)
    except OSError:  # too many links for the file system
        shutil.copyfile(there, path)


def _other_content(file: wire.BundleFile) -> InvalidBundle:
    return InvalidBundle(f"the content of {file.path!r} differs from the manifest")


def read_options(manifest: wire.Manifest, folder: Path, locate: Locate = unchanged_path) -> Options:
    """Read the options of a run from an unpacked bundle.

    Args:
        manifest: Manifest of the bundle.
        folder: Folder of the unpacked bundle.
        locate: Function that maps absolute paths of the sender.

    Raises:
        UsageError: The options contradict each other.
    """
    given = manifest.options
    options = Options(
        name=given.name,
        seed=given.seed,
        overrides=given.overrides,
        parameters=None if given.parameters is None else folder / given.parameters,
        constraints=given.constraints,
        clock=_clock(given.clock),
        simulator=None if given.simulator is None else _simulator(given.simulator, folder),
        ros=None if given.ros is None else _ros(given.ros, folder),
        lab=None if given.lab is None else _lab(given.lab, folder, locate),
        leasing=Leasing(wait=given.leasing.wait, priority=given.leasing.priority, lease=given.leasing.lease),
        grace=given.grace,
        poses=given.poses,
        scans=given.scans,
        external=given.external,
        locate=locate,
    )
    check_options(options)
    return options


def limit_of(options: wire.BundledOptions) -> WallLimit:
    """Return the limit of the wall time of a run from a bundle."""
    of_sender, of_file = (None, options.timeout) if options.timeout_of_file else (options.timeout, None)
    return wall_limit(of_sender, "--timeout SECONDS", of_file)


def _clock(name: str | None) -> ClockName | None:
    match name:
        case None | "real" | "virtual" | "sim":
            return name
        case _:
            raise UsageError(f"unknown clock '{name}'")


def _simulator(given: wire.BundledSimulator, folder: Path) -> Simulator:
    return Simulator(
        name=given.name,
        endpoint=given.endpoint,
        world=given.world if given.world_file is None else _world(given, resolved(folder / given.world_file)),
        rate=given.rate,
        model_path=[folder / path for path in given.model_path],
        snapshot=None if given.snapshot is None else folder / given.snapshot,
    )


def _world(given: wire.BundledSimulator, file: Path) -> str:
    return file.as_uri() if given.world_by_uri else str(WorldName(str(file), given.world_parameters or ""))


def _ros(given: wire.BundledRos, folder: Path) -> Ros:
    return Ros(given.endpoint, given.domain, given.dialect, [folder / path for path in given.interfaces])


def _lab(given: wire.BundledLab, folder: Path, locate: Locate) -> Lab:
    world = read_lab(folder / given.file).world
    if world is not None and not is_world_name(world):
        path = locate(Path(WorldName.parse(world).world))
        if not path.is_relative_to(resolved(folder)) or not path.is_file():
            raise UsageError(f"missing world file {world} of the lab in the bundle", help="name a world")
    return Lab(folder / given.file, given.rate, [folder / path for path in given.model_path])
