"""Sending of bundles to an executor: its abilities, the upload of missing files, and dry runs."""

from __future__ import annotations

import json
import secrets
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeVar

import anyio

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.message import Empty
from seoro.bridges.wire.results import Result
from seoro.bundle.pack import Bundle
from seoro.embed.options import ROS_SIMULATOR
from seoro.embed.run_end import InvalidEnd, NotStarted, unpack_end
from seoro.embed.whoami import whoami
from seoro.errors import BackendError, BackendRefused, UsageError

TIMES: Final = 3  # attempts to send a file

T = TypeVar("T")


async def with_files(executor: Executor, bundle: Bundle, ask: Callable[[tuple[str, ...]], Awaitable[T]]) -> T:
    """Send missing files, and then a request that needs them.

    Args:
        executor: The executor.
        bundle: The bundle.
        ask: Sends the request, with the hashes of sent files; called again if files were removed meanwhile.

    Raises:
        UsageError, BackendError: As `upload` and `ask`.
    """
    sent = await upload(executor, bundle)
    try:
        return await ask(sent)
    except BackendRefused as refused:
        if refused.code != wire.INCOMPLETE_BUNDLE:
            raise
    return await ask((*sent, *await upload(executor, bundle)))


async def upload(executor: Executor, bundle: Bundle) -> tuple[str, ...]:
    """Send missing files; returns their hashes.

    Raises:
        UsageError: A file has changed since the bundle was made.
        BackendError: The executor rejects a file, or does not answer.
    """
    missing = await executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))
    sizes = {file.hash: file.size for file in bundle.manifest.files}
    for digest in missing.hashes:
        await _send(executor, digest, bundle.blobs[digest], sizes[digest])
    return missing.hashes


async def _send(executor: Executor, digest: str, path: Path, size: int) -> None:
    """Send a file; again from its start if the executor has lost its first parts, or has other ones."""
    for left in reversed(range(TIMES)):
        try:
            await _send_parts(executor, digest, path, size)
            return
        except BackendRefused as refused:
            if refused.code != Result.INCORRECT_STATE or not left:
                raise


async def _send_parts(executor: Executor, digest: str, path: Path, size: int) -> None:
    offset = 0
    async with await anyio.open_file(path, "rb") as file:
        while offset < size or offset == 0:
            data = await file.read(wire.CHUNK)
            if len(data) < min(wire.CHUNK, size - offset):
                raise UsageError(f"{path} changed during the upload")
            await executor.ask(wire.PUT_BLOB, wire.PutBlob(hash=digest, size=size, offset=offset, data=data))
            offset += max(len(data), 1)


async def check_ability(
    executor: Executor, bundle: Bundle, priority: int = 0, *, is_dry: bool = False, is_campaign: bool = False
) -> None:
    """Check that an executor supports a bundle.

    Args:
        executor: The executor.
        bundle: The bundle to run.
        priority: Priority of the run.
        is_dry: Whether it is a dry run.
        is_campaign: Whether it is a worker of a campaign.

    Raises:
        UsageError: The executor is too old, or misses a package.
        BackendError: The executor does not answer.
    """
    options = bundle.manifest.options
    simulator = options.simulator
    has_world_file = simulator is not None and simulator.world_file is not None
    is_ros = simulator is not None and simulator.name == ROS_SIMULATOR
    for is_wanted, minor, feature, instead in (
        (priority != 0, wire.PRIORITIES, "priorities", "submit without a priority"),
        (has_world_file, wire.WORLD_FILES, "world files", "name a world of its simulators"),
        (is_ros, wire.ROS_SIMULATORS, "simulators of ROS 2 systems", "choose another simulator"),
        (bundle.names_absolute, wire.ABSOLUTE_PATHS, "absolute paths of files", "use relative paths"),
        (is_campaign, wire.CAMPAIGNS, "campaigns", "leave out this executor"),
        (is_dry, wire.DRY_RUNS, "dry runs", "run it without `--on`"),
        (bool(options.external), wire.EXTERNAL, "events from applications", "run it without `external`"),
        (options.poses is not None, wire.POSES, "rates of poses", "leave out `--poses`"),
        (options.scans > 0.0, wire.SCANS, "scans in traces", "leave out `--scans`"),
        (options.film is not None, wire.FILMS, "video recording", "run it without a video"),
    ):
        if is_wanted:
            _check_version(executor, minor, feature, f"{instead}, or update seoro at the executor")
    if options.film is not None and simulator is not None and simulator.name not in (None, ROS_SIMULATOR):
        await _check_films(executor)


def check_emitting(executor: Executor) -> None:
    """Check that an executor supports events from applications.

    Raises:
        UsageError: The executor is too old.
    """
    _check_version(executor, wire.EXTERNAL, "events from applications", "update seoro at the executor")


def _check_version(executor: Executor, minor: int, feature: str, advice: str) -> None:
    if executor.minor < minor:
        raise UsageError(
            f"the executor '{executor.name}' is older than this seoro ({__version__}) and does not support "
            f"{feature}",
            help=advice,
        )


async def _check_films(executor: Executor) -> None:
    info = await executor.ask(wire.DESCRIBE, Empty())
    if info.films is False:
        raise UsageError(
            f"the executor '{executor.name}' cannot record videos: PyAV is not installed there",
            help="install it at the executor: pip install 'seoro[video]'",
        )


@dataclass(frozen=True)
class DryRun:
    """Result of a dry run on an executor.

    Args:
        seed: Seed of the run.
        parameters: Value of every parameter.
        texts: The same values as text of the language.
        files: Number of files of the scenario.
        size: Size of all files [bytes].
        known: Number of files that the executor had before.
    """

    seed: int
    parameters: Mapping[str, object]
    texts: Mapping[str, str]
    files: int
    size: int
    known: int


async def dry_run_bundle(executor: Executor, bundle: Bundle) -> DryRun:
    """Try a bundle on an executor.

    Raises:
        InvalidScenario, UsageError, BackendError: It cannot be run there.
    """
    await check_ability(executor, bundle, is_dry=True)
    missing: frozenset[str] = frozenset()

    async def ask(sent: tuple[str, ...]) -> wire.DryRunResult:
        nonlocal missing
        missing = missing or frozenset(sent)
        request = wire.DryRun(run=secrets.token_hex(16), manifest=bundle.manifest, by=whoami(), sent=sent)
        return await executor.ask(wire.DRY_RUN, request, wire.LONGEST_DRY_RUN)

    tried = await with_files(executor, bundle, ask)
    if tried.end:
        _refuse(tried.end)
    if tried.seed is None:
        raise BackendError("invalid reply of the executor: the result of the dry run is missing")
    files = bundle.manifest.files
    return DryRun(
        tried.seed,
        json.loads(tried.parameters),
        json.loads(tried.texts),
        len(files),
        sum(file.size for file in files),
        sum(file.hash not in missing for file in files),
    )


def _refuse(data: bytes) -> None:
    try:
        end = unpack_end(data)
    except InvalidEnd as error:
        raise BackendError(str(error)) from error
    if isinstance(end, NotStarted):
        raise end.error
