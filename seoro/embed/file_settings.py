"""Settings of a run: options of the caller, merged with directives of the file and settings of the project.

Options take precedence over directives, and these over settings of the project. A directive that a single run
cannot follow, or that an option replaces, becomes a note for the user.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from seoro.embed.directives import Directives, read_directives
from seoro.embed.options import Lab, Options, Simulator
from seoro.embed.parameter_files import read_parameters
from seoro.embed.runnable import Runnable
from seoro.embed.time_limit import WallLimit, wall_limit
from seoro.errors import UsageError
from seoro.lang.frozen import Value
from seoro.lang.projects import settings_around

ENDPOINT: Final = "endpoint"
_WITHOUT_SIMULATOR: Final = ("real", "virtual")  # clocks


class FileSettings(Value):
    """Settings of a run.

    Args:
        overrides: Values of parameters by path, which no option replaces.
        constraints: Constraints on parameters, besides those of options.
        simulator: Name of the simulator to start; None for none.
        world: Name or path of its world; None for its default.
        rate: Simulated seconds per second; None for the default of the caller.
        model_path: Folders to search for models, after those of options.
        lab: Lab file of the project, for runs that name no simulator; None for none.
        seed: Seed of the run; None to draw one.
        seeds: All seeds that the file lists, for runners of several runs; empty if an option gives one.
        limit: Limit of the wall time.
        notes: Notes for the user.
    """

    overrides: Mapping[str, str]
    constraints: Sequence[str]
    simulator: str | None
    world: str | None
    rate: float | None
    model_path: Sequence[Path]
    lab: Path | None
    seed: int | None
    seeds: Sequence[int]
    limit: WallLimit
    notes: Sequence[str]


def settings_of_file(
    scenario: Runnable,
    options: Options,
    option_names: Mapping[str, str],
    *,
    world: str | None = None,
    repeats: bool = False,
) -> FileSettings:
    """Merge the directives of a file with the options of a run.

    Args:
        scenario: The file.
        options: The options; they take precedence.
        option_names: Names of options as the user writes them, for messages: `timeout`, and those of `_target`.
        world: World of the user for a simulator that the file names.
        repeats: Whether the caller runs the scenario with every seed.

    Raises:
        InvalidScenario: The file has no such scenario.
        UsageError: A directive or setting is invalid, or its world has no simulator; the error has its place.
    """
    file = scenario.file
    found = read_directives(file, scenario.scenario_lines)
    entry = scenario.entry(options.name)
    directives = found.scenarios.get(entry.line, found.common)
    project = settings_around(file.path)
    target = _target(options)
    simulator = None if options.simulator is None else options.simulator.name
    if options.simulator is not None:
        world = options.simulator.world
    notes = [*_notes(directives, options, simulator, target, option_names)]
    if simulator is None and target is None:
        simulator = next(iter(directives.simulators), project.get("simulator"))
    lab: Path | None = project.get("lab") if simulator is None and target is None else None
    if directives.world is not None and world is None and simulator is None and target is None:
        raise UsageError(
            f"{file.name} needs the world `{directives.world}`, but the run has no simulator",
            help="add `--sim mujoco`, or `# seoro: simulators mujoco` to the file",
        )
    has_simulator = target == ENDPOINT or (simulator is not None and target is None)
    if world is None and has_simulator:
        world = directives.world or project.get("world")
    seeds = directives.seeds if options.seed is None else ()
    if len(seeds) > 1 and not repeats:
        notes.append(f"this run uses seed {seeds[0]} of {_listed(seeds)}")
    return FileSettings(
        overrides=_overrides(directives, options, entry.name),
        constraints=directives.constraints,
        simulator=simulator,
        world=world,
        rate=project.get("rate") if has_simulator or lab is not None else None,
        model_path=project.get("model-path", ()) if has_simulator or lab is not None else (),
        lab=lab,
        seed=options.seed if options.seed is not None else next(iter(seeds), None),
        seeds=seeds,
        limit=wall_limit(options.timeout, option_names["timeout"], directives.timeout, project.get("timeout")),
        notes=[f"{file.name}: {note}" for note in notes],
    )


def _overrides(directives: Directives, options: Options, entry: str) -> Mapping[str, str]:
    """Return the values of the directives; options replace a value, also by one of a parameter around it."""
    if not directives.overrides:
        return {}
    given = [*options.overrides]
    if options.parameters is not None:
        given += read_parameters(options.parameters, entry)
    return {
        path: value
        for path, value in directives.overrides
        if not any(path == each or path.startswith(f"{each}.") for each in given)
    }


def _target(options: Options) -> str | None:
    """Return the option that selects the backends of actors, other than the name of a simulator, if any."""
    simulator = options.simulator
    clock = options.clock if options.clock in _WITHOUT_SIMULATOR else None
    selected: dict[str, object]
    if simulator is None:
        selected = {"lab": options.lab, "ros": options.ros, "clock": clock}
    else:
        selected = {"snapshot": simulator.snapshot, ENDPOINT: simulator.endpoint, "lab": options.lab}
    return next((name for name, value in selected.items() if value is not None), None)


def _notes(
    directives: Directives,
    options: Options,
    simulator: str | None,
    target: str | None,
    option_names: Mapping[str, str],
) -> Iterator[str]:
    listed, choice = directives.simulators, " or ".join(directives.simulators)
    if target is not None and target != ENDPOINT:
        if listed:
            yield f"`{option_names.get(target, target)}` replaces its simulator {choice}"
        if directives.world is not None:
            yield f"`{option_names.get(target, target)}` replaces its world `{directives.world}`"
    elif listed and simulator is not None and simulator not in listed:
        yield f"this run uses {simulator} instead of its simulator {choice}"
    elif len(listed) > 1 and simulator is None and target is None:
        yield f"this run uses {listed[0]} of its simulators {_listed(listed)}"
    if options.parameters is not None:
        return
    varied = [axis.name for axis in directives.axes if axis.name not in options.overrides]
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
    found = settings_of_file(scenario, options, {"timeout": timeout_option})
    lab = options.lab
    if simulator is not None:
        models = (*simulator.model_path, *found.model_path)
        simulator = replace(simulator, name=found.simulator, world=found.world, model_path=models)
    elif found.simulator is not None:
        simulator = Simulator(found.simulator, world=found.world, model_path=found.model_path)
    elif found.lab is not None:
        lab = Lab(found.lab, model_path=found.model_path)
    if found.rate is not None and options.simulator is None:
        simulator = simulator and replace(simulator, rate=found.rate)
        lab = lab and replace(lab, rate=found.rate)
    overrides = {**found.overrides, **options.overrides}
    constraints = (*found.constraints, *options.constraints)
    settings = replace(
        options, overrides=overrides, constraints=constraints, simulator=simulator, lab=lab, seed=found.seed
    )
    return settings, found
