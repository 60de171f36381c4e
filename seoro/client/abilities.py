"""What an executor can do: what it is too old for, or has not installed, is said before anything is sent."""

from __future__ import annotations

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bridges.wire.message import Empty
from seoro.bundle.packing import Bundle
from seoro.embed.options import OF_ROS
from seoro.errors import InvalidUse


async def check_ability(executor: Executor, bundle: Bundle, priority: int = 0, *, is_dry: bool = False) -> None:
    """Refuse what an executor cannot do.

    Args:
        executor: The executor.
        bundle: What is to be run there.
        priority: Of the run.
        is_dry: Whether it is only tried.

    Raises:
        InvalidUse: It is too old, or has not installed what that takes.
        BackendError: It is gone.
    """
    options = bundle.manifest.options
    simulator = options.simulator
    has_world_file = simulator is not None and simulator.world_file is not None
    lacking = (
        (priority != 0, wire.PRIORITIES, "knows no priorities", "submit without"),
        (has_world_file, wire.WORLD_FILES, "takes no world files", "name a world that its simulators have"),
        (
            simulator is not None and simulator.name == OF_ROS,
            wire.ROS_SIMULATORS,
            "uses no simulators of ROS 2 systems",
            "name another simulator",
        ),
        (
            bundle.names_absolute,
            wire.ABSOLUTE_PATHS,
            "does not find files by absolute paths",
            "name files by relative paths",
        ),
        (is_dry, wire.DRY_RUNS, "makes no dry runs", "try it without `--on`"),
        (options.film is not None, wire.FILMS, "records no films", "run it without a film"),
    )
    for is_wanted, minor, lacks, instead in lacking:
        if is_wanted and executor.minor < minor:
            raise InvalidUse(
                f"the executor '{executor.name}' is older than this seoro ({__version__}), and {lacks}",
                help=f"{instead}, or renew the executor",
            )
    if options.film is not None and simulator is not None and simulator.name not in (None, OF_ROS):
        await _check_films(executor)


async def _check_films(executor: Executor) -> None:
    info = await executor.ask(wire.DESCRIBE, Empty())
    if info.films is False:
        raise InvalidUse(
            f"the executor '{executor.name}' cannot record films: PyAV is not installed there",
            help="there, pip install 'seoro[video]'",
        )
