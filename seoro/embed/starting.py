"""Runs of scenarios that were loaded: what is asked for is opened, and the plan instantiated."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager
from typing import TYPE_CHECKING, Any, Unpack

from seoro import __version__
from seoro.embed.checking import check_options
from seoro.embed.file_settings import with_file_settings
from seoro.embed.opening import actors_of, clock_of, open_backends, open_ros
from seoro.embed.options import OptionFields, Options, options_from
from seoro.embed.runs import Run
from seoro.embed.scenarios import Scenario, to_scenario
from seoro.errors import InvalidUse
from seoro.lab.wishes import split_wishes
from seoro.lang.frontend import lower
from seoro.lang.lower.entry import find_entry
from seoro.lang.plan import Plan
from seoro.parameters import read_parameters
from seoro.people import whoami
from seoro.runtime.needs import NoHome
from seoro.runtime.reading import Readers
from seoro.runtime.run import Execution, Settings
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.runtime.accept import Acceptance

SEED_BITS = 32  # of a seed that is drawn


@asynccontextmanager
async def start(scenario: Scenario, **options: Unpack[OptionFields]) -> AsyncIterator[Run]:
    """Start a run; it is stopped, and has cleaned up, when the block ends.

    Args:
        scenario: What `load` returned.
        options: The fields of `Options`, by name.

    Raises:
        InvalidScenario, InvalidUse: It cannot be run like this; nothing has happened then.
        BackendError: The simulator did not start.
    """
    async with start_as(scenario, options_from(options), "timeout=SECONDS") as run:
        yield run


@asynccontextmanager
async def start_as(scenario: Scenario, options: Options, timeout_option: str) -> AsyncIterator[Run]:
    """Start a run, as `start`, for a caller whose users write options in another way.

    Args:
        scenario: What `load` returned.
        options: The options.
        timeout_option: What gives the limit of wall time, for messages.

    Raises:
        InvalidScenario, InvalidUse, BackendError: As `start`.
    """
    settings, found = with_file_settings(to_scenario("scenario", scenario).checked, options, timeout_option)
    async with prepare(scenario, settings) as run, run.running(found.limit):
        run.notes = tuple(found.notes)
        yield run


def run(scenario: Scenario, **options: Unpack[OptionFields]) -> Verdict:
    """Run a scenario to its end, for scripts that have no event loop: one is made for it.

    Ctrl-C stops the run, which cleans up, and is raised then.

    Args:
        scenario: What `load` returned.
        options: The fields of `Options`, by name; `observers` see the trace.

    Raises:
        InvalidScenario, InvalidUse, BackendError: As `start`; `InvalidUse` also if there is an event loop.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return asyncio.run(_run(scenario, options))
    raise InvalidUse(
        "`seoro.run` makes an event loop, and here is one already",
        help="run it there: `async with seoro.start(scenario) as run: verdict = await run.result()`",
    )


async def _run(scenario: Scenario, options: OptionFields) -> Verdict:
    async with start(scenario, **options) as started:
        return await started.result()


@asynccontextmanager
async def prepare(scenario: Scenario, options: Options) -> AsyncIterator[Run]:
    """Instantiate a run without starting it; what it needs is open while the block lasts.

    Raises:
        InvalidScenario, InvalidUse, BackendError: As `start`.
    """
    clock, rate = check_options(options)
    overrides, wishes = split_wishes(_overrides(scenario, options))
    if wishes and options.lab is None:
        wish = next(iter(wishes))
        raise InvalidUse(f"`{wish}` is to be a robot of a lab, and there is none", help="add `--lab FILE.yaml`")
    plan = lower(scenario.checked, options.name, overrides)
    if options.vet is not None:
        options.vet(plan)
    seed = secrets.randbits(SEED_BITS) if options.seed is None else options.seed
    readers = Readers(options.keep_trace)
    async with (
        open_backends(options, seed, _purpose(plan), actors_of(plan), wishes) as opened,
        open_ros(options) as systems,
    ):
        settings = Settings(
            seed=seed,
            clock=clock_of(clock, opened.simulator, rate, readers),
            backends=(*opened.backends, *systems),
            placements=opened.placements,
            observers=(readers, *options.observers),
            actions=scenario.functions.actions,
            modifiers=scenario.functions.modifiers,
            output_directory=options.output_directory,
            locate=options.locate,
            overrides=overrides,
            grace=options.grace,
            version=__version__,
        )
        with _naming_robots(options):
            execution = Execution(plan, settings)
        yield Run(execution, seed, opened, readers)


@contextmanager
def _naming_robots(options: Options) -> Iterator[None]:
    """Add the robots of the lab to the error of a run in which an actor has no robot."""
    try:
        yield
    except NoHome as error:
        if options.lab is None:
            raise
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

        robots = read_lab(options.lab.file).robots
        some = next(iter(robots), "NAME")
        actor = error.actor or "ACTOR"
        hint = f"robots of the lab: {', '.join(robots) or 'none'}; choose one with `--set {actor}=robot:{some}`"
        raise InvalidUse(error.message, error.span, hint) from error


def announcement(run: Run, options: Options) -> str:
    """What a run runs with, in a line for people."""
    simulator = run.simulator
    where = f", {simulator.features.engine} with world '{simulator.features.world}'" if simulator else ""
    where += f", lab {options.lab.file}" if options.lab else ""
    lives = "".join(f", actor `{actor}` is the robot `{robot}`" for actor, robot in run.substitutions.items())
    return f"seed {run.seed}{where}{lives}"


def accept(scenario: Scenario, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Whether the trace of a run is accepted by its scenario (7.6), by a check that is independent of the runtime.

    Args:
        scenario: What `load` returned.
        records: The records of the trace, as `Run.trace` gives them or as they are in a file.

    Raises:
        InvalidScenario, InvalidUse: The trace is of a scenario that is not in the file, or sets what that does not
            have.
    """
    from seoro.runtime.accept import check_trace  # noqa: PLC0415 - a seventh of what a run loads, which does without

    start: Mapping[str, Any] = next((each for each in records if each.get("kind") == "run.start"), {})
    name, overrides = start.get("scenario"), start.get("overrides", {})
    if not isinstance(name, str) or not isinstance(overrides, dict):
        raise InvalidUse("the trace does not say what was run: `run.start` needs `scenario` and `overrides`")
    plan = lower(scenario.checked, name, {str(path): str(value) for path, value in overrides.items()})
    return check_trace(plan, records)


def _purpose(plan: Plan) -> str:
    """What robots are held for, in words for others who want them."""
    return f"the scenario {plan.entry} of {whoami()}"


def _overrides(scenario: Scenario, options: Options) -> Mapping[str, str]:
    if options.parameters is None:
        return options.overrides
    entry = find_entry(scenario.checked, options.name).qualified_name
    return {**read_parameters(options.parameters, entry), **options.overrides}
