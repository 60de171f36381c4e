"""Abilities of an executor: missing ones are reported before anything is sent."""

from __future__ import annotations

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.message import Empty
from seoro.bundle.pack import Bundle
from seoro.embed.options import ROS_SIMULATOR
from seoro.errors import UsageError


async def check_ability(executor: Executor, bundle: Bundle, priority: int = 0, *, is_dry: bool = False) -> None:
    """Check that an executor supports a bundle.

    Args:
        executor: The executor.
        bundle: The bundle to run.
        priority: Priority of the run.
        is_dry: Whether it is a dry run.

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
        (is_dry, wire.DRY_RUNS, "dry runs", "run it without `--on`"),
        (bool(options.external), wire.EXTERNAL, "events from applications", "run it without `external`"),
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
