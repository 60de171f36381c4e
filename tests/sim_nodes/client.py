"""A client of a simulator in the same process; requests and answers go through the wire's encoding."""

from __future__ import annotations

from importlib import resources
from typing import TypeVar

from seoro.bridges import wire
from seoro.bridges.wire import Orientation3D, Pose3D, Position3D, Verb
from sim_nodes import verbs
from sim_nodes.geometry import Pose2
from sim_nodes.simulator import Simulator
from tests.sim_nodes.engines import make_engine

Q = TypeVar("Q", bound=wire.Message)
A = TypeVar("A", bound=wire.Message)

ROBOT = "turtlebot4"
TRUTH = "turtlebot4_base_link_gt"
BOX = resources.files("seoro").joinpath("models/example_simulation/models/box.sdf").read_text(encoding="utf-8")


def pose(x: float, y: float, yaw: float = 0.0, z: float = 0.0) -> Pose3D:
    return Pose3D(Position3D(x, y, z), Orientation3D(yaw=yaw))


class Client:
    """Client of a simulator."""

    def __init__(self, world: str | wire.Snapshot = "maze", seed: int | None = 0, engine: str = "mujoco") -> None:
        self.simulator = Simulator(make_engine(engine), world, seed)

    def ask(self, verb: Verb[Q, A], request: Q) -> A:
        return verb.read_reply(verbs.handle(self.simulator, verb.name, wire.encode(request)))

    @property
    def truth(self) -> Pose2:
        return self.simulator.simulation.frames.true_pose(ROBOT)

    @property
    def estimate(self) -> Pose2:
        estimate = self.simulator.simulation.robot(ROBOT).mobile.localised_pose()
        assert estimate is not None
        return estimate

    def advance(self, until: float) -> wire.Advanced:
        return self.ask(wire.ADVANCE, wire.Advance(until=until))

    def localise(self, at: Pose3D | None = None) -> None:
        self.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=ROBOT, pose=at or pose(0.0, 0.0)))

    def navigate(
        self, *poses: Pose3D, goal: str = "goal", stop_at_each: bool = False, feedback_period: float = 0.0
    ) -> None:
        request = wire.NavigateThroughPoses(
            id=goal, robot=ROBOT, poses=poses, stop_at_each=stop_at_each, feedback_period=feedback_period
        )
        self.ask(wire.NAVIGATE_THROUGH_POSES, request)

    def spawn(self, name: str, at: Pose3D, model: str = BOX, *, rename: bool = False) -> str:
        request = wire.SpawnEntity(
            name=name, uri="box.sdf", resource_string=model, initial_pose=at, allow_renaming=rename
        )
        return self.ask(wire.SPAWN_ENTITY, request).name

    def watch(self, x: float, y: float, threshold: float, frame: str = TRUTH, watch: str = "near") -> None:
        request = wire.WatchProximity(
            id=watch, frame=frame, parent_frame="map", point=Position3D(x, y), threshold=threshold
        )
        self.ask(wire.WATCH_PROXIMITY, request)

    def run_until(self, occurrence: str, limit: float = 60.0) -> tuple[wire.Occurrence, list[wire.Contact]]:
        """Grant time until the event with an id."""
        contacts: list[wire.Contact] = []
        while True:
            advanced = self.advance(limit)
            contacts += advanced.contacts
            for happened in advanced.occurrences:
                if happened.id == occurrence:
                    return happened, contacts
            assert advanced.time < limit, f"{occurrence} has not happened after {limit} s"


def obstacle_run(seed: int, engine: str) -> tuple[Client, wire.Occurrence, list[wire.Contact]]:
    """Drive through the maze to (3, -3); a box is spawned in the way when the robot is near (1.5, -1.5)."""
    client = Client(seed=seed, engine=engine)
    client.localise()
    client.navigate(pose(3.0, -3.0))
    client.watch(1.5, -1.5, 0.4)
    _, before = client.run_until("near")
    client.spawn("box", pose(2.0, -2.0, z=0.1))
    ended, after = client.run_until("goal")
    return client, ended, before + after
