"""Simulator as a whole: features, world, simulation state and resets."""

from __future__ import annotations

from enum import IntFlag, StrEnum

from seoro.bridges.wire.message import Empty, Message, Query, Verb


class SimulationState(StrEnum):
    """States of `simulation_interfaces`; stopped is paused at the initial state."""

    STOPPED = "stopped"
    PLAYING = "playing"
    PAUSED = "paused"
    NO_WORLD = "no_world"


class RobotInfo(Message):
    """Robot of the world.

    `kinds` are the actor types that it can play, most specific first. `frames` are its transform frames, `devices`
    its parts that can have faults. With `senses_contacts`, every contact of the robot is reported with its
    strikers. Bridges list the verbs of the robot; without `verbs`, all of the node apply.
    """

    name: str
    kinds: tuple[str, ...]
    frames: tuple[str, ...] = ()
    devices: tuple[str, ...] = ()
    senses_contacts: bool = False
    verbs: tuple[str, ...] = ()


class RobotName(Message):
    """A robot by name."""

    robot: str


class SimulatorFeatures(Message):
    """Features of a simulator node, sent at any time.

    `world_number` increases whenever another world is loaded, or the world is unloaded. Reloading the same world
    keeps the number. Nodes that do not count worlds send 0.
    """

    features: tuple[str, ...]  # names of the served verbs
    robots: tuple[RobotInfo, ...]
    time: float
    step: float  # length of one physics step [s]
    state: SimulationState
    world: str
    available_worlds: tuple[str, ...] = ()
    spawn_formats: tuple[str, ...] = ()  # such as "sdf"
    engine: str = ""
    engine_version: str = ""
    version: str = ""  # of seoro, or of the node
    world_number: int = 0
    warnings: tuple[str, ...] = ()  # about ignored parts of the files of the world


class LoadWorld(Message):
    """Load a world by name or path, and start at time zero; an empty name reloads the present world."""

    world: str
    seed: int = 0


class ChangeWorld(Message):
    """Load a world by name or path in the middle of a run.

    The clock continues, active goals end as canceled, and watches continue in the new world. The request is
    refused, without effect, unless the new world has every robot that is busy, watched or named in `robots`: by
    name, with the same actor type.
    """

    world: str
    robots: dict[str, str]


class SetSimulationState(Message):
    """Change the simulation state.

    `rate` is the speed of playing in simulated seconds per second; infinite for as fast as possible.
    """

    state: SimulationState
    rate: float = 1.0


class StepSimulation(Message):
    """Simulate some physics steps; only while paused."""

    steps: int = 1


class ResetScope(IntFlag):
    """Scope of a reset; `DEFAULT` is everything."""

    DEFAULT = 0
    TIME = 1
    STATE = 2
    SPAWNED = 4
    ALL = 255


class ResetSimulation(Message):
    """Reset; `scope` is a bit field of `ResetScope`."""

    scope: int = ResetScope.DEFAULT


class SimulationTime(Message):
    """The simulator's clock [s]."""

    time: float


GET_SIMULATOR_FEATURES = Query("get_simulator_features", Empty, SimulatorFeatures)
LOAD_WORLD = Verb("load_world", LoadWorld, SimulatorFeatures)
CHANGE_WORLD = Verb("change_world", ChangeWorld, SimulatorFeatures)
UNLOAD_WORLD = Verb("unload_world", Empty, Empty)
SET_SIMULATION_STATE = Verb("set_simulation_state", SetSimulationState, Empty)
STEP_SIMULATION = Verb("step_simulation", StepSimulation, SimulationTime)
RESET_SIMULATION = Verb("reset_simulation", ResetSimulation, Empty)
