"""Preparation of a run: open its backends, and instantiate the plan of its scenario."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from random import SystemRandom
from typing import TYPE_CHECKING

from seoro import __version__
from seoro.embed.backends import make_clock, open_backends, open_ros
from seoro.embed.directives import requirements_of
from seoro.embed.option_checks import check_options
from seoro.embed.options import SEED_BITS, Options, pose_rate
from seoro.embed.runnable import Runnable
from seoro.embed.runs import Run
from seoro.embed.world_settings import split_world, with_world
from seoro.errors import UsageError
from seoro.runtime.actions.needs import MissingRobot
from seoro.runtime.events.occurrence import Occurrence, is_emitted_outside, occurrence_in
from seoro.runtime.execution.settings import Settings
from seoro.runtime.run import Execution
from seoro.runtime.trace.reader import Readers

if TYPE_CHECKING:
    from seoro.lab.selectors import Selector


@asynccontextmanager
async def prepare(scenario: Runnable, options: Options) -> AsyncIterator[Run]:
    """Instantiate a run without starting it; its backends are open while the block lasts.

    Raises:
        InvalidScenario, UsageError, BackendError: As `start`.
    """
    given, options = options, with_world(options)
    clock, rate = check_options(options)
    overrides, selectors = _overrides(scenario, options)
    if selectors and options.lab is None:
        selector = next(iter(selectors))
        raise UsageError(f"the actor `{selector}` needs a robot of a lab", help="add `--lab FILE.yaml`")
    plan = scenario.plan(options.name, overrides, options.constraints)
    if options.vet is not None:
        options.vet(plan)
    seed = SystemRandom().getrandbits(SEED_BITS) if options.seed is None else options.seed
    readers = Readers(options.keep_trace)
    recorded: list[Occurrence] | None = None
    if options.replay is not None:
        recorded = [occurrence_in(record) for record in options.replay if is_emitted_outside(record)]
    async with (
        open_backends(options, seed, plan, selectors) as opened,
        open_ros(options) as systems,
    ):
        settings = Settings(
            seed=seed,
            clock=make_clock(clock, opened, rate, readers, options.debugger),
            rate=math.inf if opened.simulator is None else rate,
            backends=(*opened.backends, *systems),
            placements=opened.placements,
            observers=(readers, *options.observers, *(each for system in systems for each in system.observers)),
            actions=scenario.functions.actions,
            modifiers=scenario.functions.modifiers,
            output_directory=options.output_directory,
            locate=options.locate,
            overrides={**overrides, **split_world(given.overrides)[1]},
            constraints=options.constraints,
            requirements=requirements_of(scenario, options.name),
            grace=options.grace,
            version=__version__,
            sources=scenario.files,
            external=options.external,
            recorded=recorded,
            pose_rate=pose_rate(options),
            scan_rate=options.scans,
            debugger=options.debugger,
        )
        with _naming_robots(options):
            execution = Execution(plan, settings)
        yield Run(execution, seed, opened, readers)


@contextmanager
def _naming_robots(options: Options) -> Iterator[None]:
    """Add the robots of the lab to the error about an actor without a robot."""
    try:
        yield
    except MissingRobot as error:
        if options.lab is None:
            raise
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

        robots = read_lab(options.lab.file).robots
        some = next(iter(robots), "NAME")
        actor = error.actor or "ACTOR"
        hint = f"robots of the lab: {', '.join(robots) or 'none'}; choose one with `--set {actor}=robot:{some}`"
        raise UsageError(error.message, error.span, hint) from error


def announcement(run: Run, options: Options) -> str:
    """Describe the seed, simulator and robots of a run in one line."""
    simulator = run.simulator
    where = f", {simulator.features.engine} with world '{simulator.features.world}'" if simulator else ""
    where += f", lab {options.lab.file}" if options.lab else ""
    lives = "".join(f", actor `{actor}` is robot `{robot}`" for actor, robot in run.substitutions.items())
    return f"seed {run.seed}{where}{lives}"


def _overrides(scenario: Runnable, options: Options) -> tuple[Mapping[str, str], Mapping[str, Selector]]:
    """Split the overrides into values of parameters and selectors of robots."""
    given = options.overrides
    if options.parameters is not None:
        from seoro.embed.parameter_files import read_parameters  # noqa: PLC0415 - for files of parameters only

        given = {**read_parameters(options.parameters, scenario.entry(options.name).name), **given}
    if not given:
        return {}, {}
    from seoro.lab.selectors import split_selectors  # noqa: PLC0415 - for runs with overrides only

    return split_selectors(given)
