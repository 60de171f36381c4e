"""The simulator as a whole: what it is, its world, its state, what is reset."""

from __future__ import annotations

from enum import IntFlag, StrEnum

from seoro.bridges.wire.message import Empty, Message, Verb


class SimulationState(StrEnum):
    """States of `simulation_interfaces`; stopped is paused at the initial state."""

    STOPPED = "stopped"
    PLAYING = "playing"
    PAUSED = "paused"
    NO_WORLD = "no_world"


class RobotInfo(Message):
    """A robot of the world.

    `kinds` are the actor types it can stand for, most specific first; `frames` the transform frames it has,
    `devices` what can have faults. With `senses_contacts`, every contact of the robot is reported, with who moved
    into whom.
    """

    name: str
    kinds: tuple[str, ...]
    frames: tuple[str, ...]
    devices: tuple[str, ...] = ()
    senses_contacts: bool = False


class SimulatorFeatures(Message):
    """What a node is and has; answered at any time.

    `world_number` is another one, and a higher one, whenever the world is another than before, or none is loaded
    any more; a world that is loaded again as it is keeps its number. It is 0 from nodes that do not count them.
    """

    engine: str
    engine_version: str
    version: str  # of seoro
    features: tuple[str, ...]  # names of the verbs it serves
    spawn_formats: tuple[str, ...]  # such as "sdf"
    world: str
    available_worlds: tuple[str, ...]
    robots: tuple[RobotInfo, ...]
    time: float
    step: float  # length of one physics step [s]
    state: SimulationState
    world_number: int = 0
    warnings: tuple[str, ...] = ()  # about the files of the world: what in them is ignored


class LoadWorld(Message):
    """Load a world by name or path, and start over at time zero; an empty name is the world that is loaded."""

    world: str
    seed: int = 0


class ChangeWorld(Message):
    """Load a world by name or path in the middle of a run.

    The clock goes on, goals that are active end as canceled, and watches go on in the new world. It is refused,
    and nothing changes, unless that has every robot which is busy or watched, and those of `robots`: by name, each
    with the actor type that it stands for.
    """

    world: str
    robots: dict[str, str]


class SetSimulationState(Message):
    """Go to a simulation state.

    `rate` is how fast it plays then, in simulated seconds per second; infinite for as fast as possible.
    """

    state: SimulationState
    rate: float = 1.0


class StepSimulation(Message):
    """Make physics steps; only while paused."""

    steps: int = 1


class ResetScope(IntFlag):
    """What a reset covers; `DEFAULT` is everything."""

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


GET_SIMULATOR_FEATURES = Verb("get_simulator_features", Empty, SimulatorFeatures)
LOAD_WORLD = Verb("load_world", LoadWorld, SimulatorFeatures)
CHANGE_WORLD = Verb("change_world", ChangeWorld, SimulatorFeatures)
UNLOAD_WORLD = Verb("unload_world", Empty, Empty)
SET_SIMULATION_STATE = Verb("set_simulation_state", SetSimulationState, Empty)
STEP_SIMULATION = Verb("step_simulation", StepSimulation, SimulationTime)
RESET_SIMULATION = Verb("reset_simulation", ResetSimulation, Empty)
