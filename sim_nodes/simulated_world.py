"""The parts of a simulated world: its engine, entities, robots and records, and their present values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from threading import Event
from typing import Any

from seoro.bridges import wire
from sim_nodes.agents.agents import Agents
from sim_nodes.agents.drawing import draw_agents
from sim_nodes.agents.walls import Walls
from sim_nodes.buildings.buildings import Buildings
from sim_nodes.clearance import Clearance, Search
from sim_nodes.departures import Departures
from sim_nodes.entities import Entities
from sim_nodes.event_log import EventLog, WorldEvent
from sim_nodes.faults.devices import FreeCameras
from sim_nodes.faults.registry import FaultRegistry
from sim_nodes.frames import Frames
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.outcomes import NO_CLIENT, unknown
from sim_nodes.pace import Batches
from sim_nodes.physics import BodyState, DrivesBodies, Engine, PlacedRobot
from sim_nodes.recording import Recording
from sim_nodes.robots.robot import Robot
from sim_nodes.run_data import RunData
from sim_nodes.scenery import describe_scene
from sim_nodes.sensors.sensor_pipeline import Sample, SensorPipeline
from sim_nodes.stateful import Stateful
from sim_nodes.streams import Streams
from sim_nodes.strikes import Contacts, Strikes
from sim_nodes.terrain.surface import Surface
from sim_nodes.ticks import TICK
from sim_nodes.tracks import Tracks
from sim_nodes.views import Picture
from sim_nodes.watches import Watches
from sim_nodes.worlds.loader import World


class SimulatedWorld(Stateful):
    """A world in an engine, at a time.

    Args:
        engine: The engine; its scene is replaced.
        world: The world.
        seed: Seed of all randomness.

    Attributes:
        watches: Watches of clients.
        pending: Events since the last call of `collect`.
    """

    STATE = (
        "_steps",
        "_epoch",
        "watches",
        "_touched",
        "strikes",
        "departures",
        "entities",
        "agents",
        "buildings",
        "camera_faults",
        "robots",
        "run_data",
        "pending",
    )

    DERIVED = ("streams", "log", "tracks", "halted", "_batches")  # of the simulator and the machine

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self.engine = engine
        self._driving_engine = engine if isinstance(engine, DrivesBodies) else None  # the check takes long
        self.world = world
        self.seed = seed
        self.known = build_map(world.extent, world.walls, world.outlines)
        self._surface = Surface(world.ground, self.known)
        self._walls = Walls(self.known)
        circles = _robot_circles(world.robots).values()
        self._drawn = draw_agents(world.agents, world.name, seed, self._walls, circles)
        self._tick_steps = round(TICK * engine.steps_per_second)
        self.recording = Recording(engine, world, lambda: self.entities)
        self.streams = Streams()
        self.log = EventLog()
        self.tracks = Tracks()
        self.halted = Event()
        self._batches = Batches()
        self._start_over()

    def _start_over(self) -> None:
        self.engine.build(self.world.scene)
        self._steps = 0
        self._epoch = 0  # step at which the clock shows zero
        self.watches = Watches()
        self._touched = Contacts(self.engine.steps_per_second)
        self.entities = Entities(self.engine, self.world, self.seed, self._drawn)
        self._make_robots()
        self.pending: list[WorldEvent] = []

    def _make_robots(self) -> None:
        placed = self.world.robots
        self.camera_faults = FaultRegistry("", FreeCameras(self.entities.cameras))
        self.robots = {
            robot.name: Robot(robot, self.engine, self.entities, self._surface, self.seed, self.world.origin)
            for robot in placed
        }
        self._rendered = tuple(pipeline for robot in self.robots.values() for pipeline in robot.rendered_sensors)
        radii = {name: radius for name, (_, radius) in _robot_circles(placed).items()}
        self.agents = Agents(self.engine, self.entities, radii, self._walls, self.seed)
        self.buildings = Buildings(self.world.building, self.engine)
        self.departures = Departures(self.world.extent)
        self.frames = Frames(self.engine, self.robots, self.entities)
        self.strikes = Strikes(self.engine, self.entities, self.robots, self._tick_steps)
        for name, path in self.world.paths.items():
            self.robots[name].mobile.follow_path(path.points, path.speed, self.tick, NO_CLIENT, repeat=path.repeat)
        self.run_data = self._new_run_data({robot.name: robot.pose for robot in placed})
        self.streams.activate_sensors(self.robots)

    def _new_run_data(self, starts: Mapping[str, Pose2]) -> RunData:
        return RunData(
            self.engine,
            self.world,
            self.entities,
            self.robots,
            self.frames,
            self._surface,
            starts,
            self._touched.touches,
            self.tick,
        )

    def robot(self, name: str) -> Robot:
        """Return a robot by name.

        Raises:
            RequestRefused: The robot is unknown.
        """
        if name not in self.robots:
            raise unknown(f"robot {name!r}", "robots", self.robots)
        return self.robots[name]

    def travelled(self, robot: str) -> float:
        """Return the distance travelled by a robot's odometry [m]."""
        return self.robot(robot).mobile.odometry.travelled

    def joint_position(self, robot: str, joint: str) -> float:
        """Return the position of a joint of a robot's arm or gripper [rad, m]."""
        return self.robot(robot).arm.position_of(joint)

    def state_of(self, entity: str) -> BodyState | None:
        """Return the state of an entity; None if it is unknown."""
        return self.entities.state(entity) if self.entities.is_known(entity) else None

    def pose(self, frame: str) -> Pose2 | None:
        """Return the pose of a frame or body in `map`; None if it is unknown yet."""
        return self.frames.pose(frame)

    def clearance(self, robot: str, other: str) -> Clearance | None:
        """Return the clearance of a robot to another entity, or the nearest; None if one is unknown."""
        clearances = self.run_data.clearances
        if robot not in self.robots or (other and other not in clearances.names):
            return None
        pose = self.frames.true_pose(robot)
        return clearances.between(robot, pose, other) if other else clearances.nearest([Search(robot, pose)])[0]

    def localization_error(self, robot: str) -> float | None:
        """Return the distance between a robot's estimated and true position [m]; None without an estimate."""
        estimate = self.robot(robot).mobile.localised_pose() if robot in self.robots else None
        if estimate is None:
            return None
        truth = self.frames.true_pose(robot)
        return estimate.distance(truth.x, truth.y)

    def work(self, robot: str) -> float | None:
        """Return the mechanical work of a robot's motors [J]; None if it is unknown."""
        return self.run_data.work_of(robot)

    def building_position(self, name: str) -> float | None:
        """Return the opening of a door, or the height of a lift [m]; None if it is unknown."""
        return self.buildings.position(name)

    def pipeline(self, robot: str, sensor: str) -> SensorPipeline[Any]:
        """Return the pipeline of a robot's sensor.

        Raises:
            RequestRefused: The robot or sensor is unknown.
        """
        sensors = self.robot(robot).sensors
        if sensor not in sensors:
            raise unknown(f"sensor {sensor!r} of {robot}", "sensors", sensors)
        return sensors[sensor]

    def check_camera(self, name: str) -> None:
        """Refuse cameras that are unknown or cannot be rendered; see `Cameras.check`."""
        self.entities.cameras.check(name)

    def picture(self, camera: str) -> Sample[Picture] | None:
        """Return the present picture of a camera; None if it is unknown or gives none."""
        return self.entities.cameras.given(camera, self.tick)

    def faults_of(self, robot: str) -> FaultRegistry:
        """Return the faults of a robot; an empty name means the free cameras."""
        return self.robot(robot).faults if robot else self.camera_faults

    @property
    def shown_map(self) -> NavigationMap:
        """The map of walls, fixed props and terrain that no robot of the world can pass."""
        return self._surface.common(robot.mobile.declaration for robot in self.robots.values() if robot.drives)

    def describe_scene(self) -> wire.Scene:
        """Describe the world and its entities."""
        return describe_scene(self.time, self.world, self.engine, self.entities, self.shown_map)

    def measurements(self) -> wire.Measurements:
        """Return the measurements of robots and movable entities since the start of the run."""
        return self.run_data.measurements(self.seed, self.time)

    @property
    def time(self) -> float:
        """Simulation time [s]; a multiple of the step's length."""
        return (self._steps - self._epoch) / self.engine.steps_per_second

    @property
    def tick(self) -> int:
        """The last tick."""
        return self._steps // self._tick_steps

    def time_of_tick(self, tick: int) -> float:
        """Return the time of a tick [s]."""
        return (tick * self._tick_steps - self._epoch) / self.engine.steps_per_second


FIXED_RADIUS = 0.3  # [m] about the base of a robot that does not drive


def _robot_circles(robots: Sequence[PlacedRobot]) -> dict[str, tuple[Pose2, float]]:
    """Return the initial poses and radii [m] of robots, as people see them."""
    bases = ((robot, robot.declaration.mobile) for robot in robots)
    return {robot.name: (robot.pose, FIXED_RADIUS if base is None else base.radius) for robot, base in bases}
