"""Settings of a run: the directives of its scenario file, merged with the options of the caller.

Options take precedence over directives. A directive that a single run cannot follow, or that an option
replaces, becomes a note for the user.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from seoro.embed.directives import Directives, read_directives
from seoro.embed.options import Options, Simulator
from seoro.embed.runnable import Runnable
from seoro.embed.time_limit import WallLimit, wall_limit
from seoro.errors import UsageError
from seoro.lang.frozen import Value

SNAPSHOT: Final = "snapshot"
ENDPOINT: Final = "endpoint"
LAB: Final = "lab"
ROS: Final = "ros"
CLOCK: Final = "clock"
_WITHOUT_SIMULATOR: Final = ("real", "virtual")  # clocks


class Target(Value):
    """Option that selects the backends of actors, other than the name of a simulator.

    Args:
        kind: `SNAPSHOT`, `ENDPOINT`, `LAB`, `ROS` or `CLOCK`.
        option: The option as the user writes it.
    """

    kind: str
    option: str


def target_of(options: Mapping[str, tuple[object, str]], *, has_simulator: bool) -> Target | None:
    """Return the target that options select, or None.

    Args:
        options: For each kind of target, the value of its option (or None), and the option as the user writes it.
        has_simulator: Whether the options name a simulator; `ROS` and `CLOCK` are then ignored.
    """
    for kind in (SNAPSHOT, ENDPOINT, LAB, ROS, CLOCK):
        value, option = options[kind]
        if value is None or (has_simulator and kind in (ROS, CLOCK)):
            continue
        if kind != CLOCK or value in _WITHOUT_SIMULATOR:
            return Target(kind, option)
    return None


class GivenOptions(Value):
    """Options of a run that take precedence over directives.

    Args:
        simulator: Name of the simulator to start.
        target: Option that selects other backends than a named simulator, if any.
        world: Name or path of the world.
        seed: Seed of the run.
        timeout: Limit of wall time [s].
        timeout_option: The option that gives this limit, for messages.
        parameters: Paths of parameters with given values; None if a parameter file gives them.
    """

    simulator: str | None = None
    target: Target | None = None
    world: str | None = None
    seed: int | None = None
    timeout: float | None = None
    timeout_option: str = "--timeout"
    parameters: Collection[str] | None = ()

    @property
    def takes_world(self) -> bool:
        """Whether the target can load a world."""
        return self.target is not None and self.target.kind == ENDPOINT


class FileSettings(Value):
    """Settings of a run.

    Args:
        simulator: Name of the simulator to start; None for none.
        world: Name or path of its world; None for its default.
        seed: Seed of the run; None to draw one.
        seeds: All seeds that the file lists, for runners of several runs; empty if an option gives one.
        limit: Limit of the wall time.
        notes: Notes for the user.
    """

    simulator: str | None
    world: str | None
    seed: int | None
    seeds: Sequence[int]
    limit: WallLimit
    notes: Sequence[str]


def settings_of_file(
    scenario: Runnable, name: str | None, given: GivenOptions, *, repeats: bool = False
) -> FileSettings:
    """Merge the directives of a file with the options of a run.

    Args:
        scenario: The file.
        name: Name of the scenario to run; None for the entry of the file.
        given: The options.
        repeats: Whether the caller runs the scenario with every seed.

    Raises:
        InvalidScenario: The file has no such scenario.
        UsageError: A directive is invalid, or its world has no simulator; the error has its place.
    """
    file = scenario.file
    found = read_directives(file, scenario.scenario_lines)
    directives = found.scenarios.get(scenario.entry(name).line, found.common)
    simulator, has_target = given.simulator, given.target is not None
    if simulator is None and not has_target:
        simulator = next(iter(directives.simulators), None)
    if directives.world is not None and given.world is None and simulator is None and not has_target:
        raise UsageError(
            f"{file.name} needs the world `{directives.world}`, but the run has no simulator",
            help="add `--sim mujoco`, or `# seoro: simulators mujoco` to the file",
        )
    loads_world = given.takes_world or (simulator is not None and not has_target)
    seeds = directives.seeds if given.seed is None else ()
    notes = [*_notes(directives, given)]
    if len(seeds) > 1 and not repeats:
        notes.append(f"this run uses seed {seeds[0]} of {_listed(seeds)}")
    return FileSettings(
        simulator=simulator,
        world=directives.world if given.world is None and loads_world else given.world,
        seed=given.seed if given.seed is not None else next(iter(seeds), None),
        seeds=seeds,
        limit=wall_limit(given.timeout, given.timeout_option, directives.timeout),
        notes=[f"{file.name}: {note}" for note in notes],
    )


def _notes(directives: Directives, given: GivenOptions) -> Iterator[str]:
    listed, choice = directives.simulators, " or ".join(directives.simulators)
    if given.target is not None and not given.takes_world:
        if listed:
            yield f"`{given.target.option}` replaces its simulator {choice}"
        if directives.world is not None:
            yield f"`{given.target.option}` replaces its world `{directives.world}`"
    elif listed and given.simulator is not None and given.simulator not in listed:
        yield f"this run uses {given.simulator} instead of its simulator {choice}"
    elif len(listed) > 1 and given.simulator is None and given.target is None:
        yield f"this run uses {listed[0]} of its simulators {_listed(listed)}"
    if given.parameters is None:
        return
    varied = [axis.name for axis in directives.axes if axis.name not in given.parameters]
    if varied or directives.files:
        what = f"the parameter {_listed(varied)}" if varied else "its parameter files"
        yield f"only `pytest` varies {what}; set values with `--set` or `--params`"


def _listed(items: Sequence[object]) -> str:
    return ", ".join(map(str, items))


def with_file_settings(scenario: Runnable, options: Options, timeout_option: str) -> tuple[Options, FileSettings]:
    """Merge the directives of a file into the options of an embedding program or a client.

    Args:
        scenario: The file.
        options: Options; they take precedence over directives.
        timeout_option: Option for the limit of wall time, for messages.

    Raises:
        InvalidScenario, UsageError: As `settings_of_file`.
    """
    simulator = options.simulator
    found = settings_of_file(scenario, options.name, _given(options, timeout_option))
    if found.simulator is not None or simulator is not None:
        simulator = replace(simulator or Simulator(), name=found.simulator, world=found.world)
    return replace(options, simulator=simulator, seed=found.seed), found


def _given(options: Options, timeout_option: str) -> GivenOptions:
    simulator = options.simulator
    values = {
        SNAPSHOT: None if simulator is None else simulator.snapshot,
        ENDPOINT: None if simulator is None else simulator.endpoint,
        LAB: options.lab,
        ROS: options.ros,
        CLOCK: options.clock,
    }
    return GivenOptions(
        simulator=None if simulator is None else simulator.name,
        target=target_of(
            {kind: (value, kind) for kind, value in values.items()}, has_simulator=simulator is not None
        ),
        world=None if simulator is None else simulator.world,
        seed=options.seed,
        timeout=options.timeout,
        timeout_option=timeout_option,
        parameters=None if options.parameters is not None else options.overrides.keys(),
    )
