"""The settings that a scenario file asks for by its directives, merged with the options of one run.

Options go before directives. What a single run cannot obey, and what an option replaces, becomes a note for the
user, so that no directive is ignored silently.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from seoro.embed.directives import Directives, directives_of_file
from seoro.embed.options import Options, Simulator
from seoro.embed.walltime import WallLimit, wall_limit
from seoro.errors import InvalidUse
from seoro.lang.frontend import Checked
from seoro.lang.lower.entry import find_entry

SNAPSHOT: Final = "snapshot"
ENDPOINT: Final = "endpoint"
LAB: Final = "lab"
ROS: Final = "ros"
CLOCK: Final = "clock"
_WITHOUT_SIMULATOR: Final = ("real", "virtual")  # clocks


@dataclass(frozen=True)
class Place:
    """The option that places actors if no simulator is named.

    Args:
        kind: `SNAPSHOT`, `ENDPOINT`, `LAB`, `ROS` or `CLOCK`.
        option: The option, as the user writes it.
    """

    kind: str
    option: str


def place_of(options: Mapping[str, tuple[object, str]], *, has_simulator: bool) -> Place | None:
    """Return the place that options give, or None.

    Args:
        options: For each kind of place, the value of its option (None if it is not given), and the option as the
            user writes it.
        has_simulator: Whether the options name a simulator; `ROS` and `CLOCK` are no place then.
    """
    for kind in (SNAPSHOT, ENDPOINT, LAB, ROS, CLOCK):
        value, option = options[kind]
        if value is None or (has_simulator and kind in (ROS, CLOCK)):
            continue
        if kind != CLOCK or value in _WITHOUT_SIMULATOR:
            return Place(kind, option)
    return None


@dataclass(frozen=True)
class Given:
    """The options of a run that go before directives.

    Args:
        simulator: Name of the simulator to start.
        place: The option that decides where actors live instead of a simulator's name; None if no option does.
        world: Name or path of the world.
        seed: Seed of the run.
        timeout: Limit of wall time [s].
        timeout_option: The option that gives this limit, for messages.
        parameters: Paths of parameters with given values; None if a parameter file gives them.
    """

    simulator: str | None = None
    place: Place | None = None
    world: str | None = None
    seed: int | None = None
    timeout: float | None = None
    timeout_option: str = "--timeout"
    parameters: Collection[str] | None = ()

    @property
    def takes_world(self) -> bool:
        """Whether a world can be loaded at the place."""
        return self.place is not None and self.place.kind == ENDPOINT


@dataclass(frozen=True)
class FileSettings:
    """The settings of one run, after the directives of its file.

    Args:
        simulator: Name of the simulator to start; None for none.
        world: Name or path of its world; None for its default.
        seed: Seed of the run; None to draw one.
        seeds: All seeds that the file lists, for runners of several runs; empty if an option gives one.
        limit: Limit of wall time.
        notes: Notes for the user.
    """

    simulator: str | None
    world: str | None
    seed: int | None
    seeds: Sequence[int]
    limit: WallLimit
    notes: Sequence[str]


def settings_of_file(
    checked: Checked, scenario: str | None, given: Given, *, repeats: bool = False
) -> FileSettings:
    """Merge the directives of a file with the options of a run.

    Args:
        checked: The file.
        scenario: Name of the scenario to run; None for the entry of the file.
        given: The options.
        repeats: Whether the caller runs the scenario with every seed.

    Raises:
        InvalidScenario: The file has no such scenario.
        InvalidUse: A directive is invalid, or names a world and nothing can load it; the error has its place.
    """
    found = directives_of_file(checked)
    directives = found.scenarios.get(find_entry(checked, scenario).span.line, found.common)
    name = checked.sources.entry.file.name
    simulator, has_place = given.simulator, given.place is not None
    if simulator is None and not has_place:
        simulator = next(iter(directives.simulators), None)
    if directives.world is not None and given.world is None and simulator is None and not has_place:
        raise InvalidUse(
            f"{name} asks for the world `{directives.world}`, and the run has no simulator",
            help="add `--sim mujoco`, or `# seoro: simulators mujoco` to the file",
        )
    loads_world = given.takes_world or (simulator is not None and not has_place)
    seeds = directives.seeds if given.seed is None else ()
    notes = [*_notes(directives, given)]
    if len(seeds) > 1 and not repeats:
        notes.append(f"it lists the seeds {_listed(seeds)}; this run uses {seeds[0]}")
    return FileSettings(
        simulator=simulator,
        world=directives.world if given.world is None and loads_world else given.world,
        seed=given.seed if given.seed is not None else next(iter(seeds), None),
        seeds=seeds,
        limit=wall_limit(given.timeout, given.timeout_option, directives.timeout),
        notes=[f"{name}: {note}" for note in notes],
    )


def _notes(directives: Directives, given: Given) -> Iterator[str]:
    listed, asked = directives.simulators, " or ".join(directives.simulators)
    if given.place is not None and not given.takes_world:
        if listed:
            yield f"it asks for the simulator {asked}; `{given.place.option}` goes before it"
        if directives.world is not None:
            yield f"it asks for the world `{directives.world}`; `{given.place.option}` goes before it"
    elif listed and given.simulator is not None and given.simulator not in listed:
        yield f"it asks for the simulator {asked}; this run uses {given.simulator}"
    elif len(listed) > 1 and given.simulator is None and given.place is None:
        yield f"it lists the simulators {_listed(listed)}; this run uses {listed[0]}"
    if given.parameters is None:
        return
    varied = [axis.name for axis in directives.axes if axis.name not in given.parameters]
    if varied or directives.files:
        what = f"the parameter {_listed(varied)}" if varied else "its parameter files"
        yield f"`pytest` varies {what}; this run takes other values from `--set` and `--params` only"


def _listed(items: Sequence[object]) -> str:
    return ", ".join(map(str, items))


def with_file_settings(checked: Checked, options: Options, timeout_option: str) -> tuple[Options, FileSettings]:
    """Merge the directives of a file into the options of an embedding program or a client.

    Args:
        checked: The file.
        options: The options; those that are given go before directives.
        timeout_option: The option that gives the limit of wall time, for messages.

    Raises:
        InvalidScenario, InvalidUse: As `settings_of_file`.
    """
    simulator = options.simulator
    found = settings_of_file(checked, options.name, _given(options, timeout_option))
    if found.simulator is not None or simulator is not None:
        simulator = replace(simulator or Simulator(), name=found.simulator, world=found.world)
    return replace(options, simulator=simulator, seed=found.seed), found


def _given(options: Options, timeout_option: str) -> Given:
    simulator = options.simulator
    values = {
        SNAPSHOT: None if simulator is None else simulator.snapshot,
        ENDPOINT: None if simulator is None else simulator.endpoint,
        LAB: options.lab,
        ROS: options.ros,
        CLOCK: options.clock,
    }
    return Given(
        simulator=None if simulator is None else simulator.name,
        place=place_of(
            {kind: (value, kind) for kind, value in values.items()}, has_simulator=simulator is not None
        ),
        world=None if simulator is None else simulator.world,
        seed=options.seed,
        timeout=options.timeout,
        timeout_option=timeout_option,
        parameters=None if options.parameters is not None else options.overrides.keys(),
    )
