"""A simulator node as a backend: the runtime's contracts, spoken over the wire."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import anyio

from seoro.bridges import wire
from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.session import AsyncSession, NoAnswer, NoServer, Refused, SessionError
from seoro.errors import BackendLost, BackendRefused
from seoro.runtime.contracts import (
    GoalStatus,
    Happened,
    Lost,
    Orientation3D,
    Pose3D,
    Position3D,
    Report,
    Reporter,
    Velocity6D,
)

REQUEST_TIMEOUT = 10.0  # [s] of the machine's clock
LOSS_NOTICE = 0.5  # [s] after a request has failed
ANYTHING = "osc_actor"
GRANT_TIMEOUT = 30.0  # [s]; a node that is this slow is given up


@dataclass(frozen=True)
class NodeAddress:
    """How a node is reached: a session that is connected to it, its namespace and its name."""

    session: AsyncSession
    namespace: str
    node: str


class SimulatorNode:
    """A simulator node that has been found.

    Args:
        address: How it is reached.
        models: Where models to spawn are looked up.
        features: What it said of itself.
    """

    def __init__(self, address: NodeAddress, models: ModelPath, features: wire.SimulatorFeatures) -> None:
        self._address = address
        self._models = models
        self._features = features
        self._reporters: dict[str, Reporter] = {}
        self._ids = count(1)
        self._taken: set[str] = set()
        self._happened: Happened = _ignore
        self._lost: Lost = _ignore_loss
        self._lost_reason: str | None = None
        self._gone = anyio.Event()

    @property
    def name(self) -> str:
        """How messages call it."""
        return f"simulator '{self._address.node}'"

    @property
    def features(self) -> wire.SimulatorFeatures:
        """What the node said of itself when its world was loaded."""
        return self._features

    # -------------------------------------------------------- backend

    def home_of(self, actor: str, types: Sequence[str]) -> str | None:
        """The robot of the same name, else the first free one that can stand for the actor's type.

        An actor of the type that everything is (`osc_actor`) is a robot by its name only.
        """
        free = [robot for robot in self._features.robots if robot.name not in self._taken]
        fitting = [robot for robot in free if types[0] in robot.kinds]
        named = next((robot for robot in fitting if robot.name == actor), None)
        chosen = named or (next(iter(fitting), None) if types[0] != ANYTHING else None)
        if chosen is None:
            return None
        self._taken.add(chosen.name)
        return chosen.name

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Remember whom to tell of contacts, and of the end of the node."""
        self._happened, self._lost = happened, lost
        if self._lost_reason is not None:
            lost(self._lost_reason)

    def report_loss(self, reason: str) -> None:
        """Say that the node is gone; for whoever watches it."""
        if self._lost_reason is None:
            self._lost_reason = reason
            self._gone.set()
            self._address.session.abandon()
            self._lost(reason)

    async def advance(self, until: float) -> float:
        """Grant time; tells reporters what happened before the answer's time."""
        advanced = await self._ask(wire.ADVANCE, wire.Advance(until=until), GRANT_TIMEOUT)
        for contact in advanced.contacts:
            self._happened("contact", {"first": contact.first, "second": contact.second, "time": contact.time})
        for occurrence in advanced.occurrences:
            report = self._reporters.pop(occurrence.id, None)
            if report is not None:
                report(Report(GoalStatus(occurrence.outcome.value), occurrence.message))
        return advanced.time

    async def artifacts(self) -> tuple[wire.Artifact, ...]:
        """What the node has to show of the run."""
        return (await self._ask(wire.GET_ARTIFACTS, wire.Empty(), GRANT_TIMEOUT)).artifacts

    async def end_run(self) -> None:
        """Make every robot stand still."""
        for robot in self._features.robots:
            await self._ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot.name))

    async def clear(self) -> None:
        """Leave nothing of the run: no goal, no watch, no robot that moves, and nothing that was spawned.

        That includes what was asked for by requests whose answers nobody has awaited.
        """
        await self.end_run()
        for number in tuple(self._reporters):  # of goals, too, all of which have ended with `end_run`
            await self.cancel_watch(number)
        await self._ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.SPAWNED))

    # -------------------------------------------------------- mobile robots

    async def set_initial_pose(self, robot: str, pose: Pose3D) -> None:
        """See `MobileRobots`."""
        await self._ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=robot, pose=_pose(pose)))

    async def navigate(self, robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        """See `MobileRobots`."""
        goal = f"goal-{next(self._ids)}"
        request = wire.NavigateThroughPoses(
            id=goal, robot=robot, poses=tuple(map(_pose, poses)), stop_at_each=stop_at_each
        )
        self._reporters[goal] = report
        return await self._ask_reported(wire.NAVIGATE_THROUGH_POSES, request, goal)

    async def cancel_goal(self, goal: str) -> None:
        """See `MobileRobots`."""
        await self._forget(wire.CANCEL_GOAL, wire.CancelGoal(id=goal), goal)

    async def watch_proximity(
        self, frame: str, parent_frame: str, point: Position3D, threshold: float, report: Reporter
    ) -> str:
        """See `MobileRobots`."""
        watch = f"watch-{next(self._ids)}"
        request = wire.WatchProximity(
            id=watch, frame=frame, parent_frame=parent_frame, point=_vector(point), threshold=threshold
        )
        self._reporters[watch] = report
        return await self._ask_reported(wire.WATCH_PROXIMITY, request, watch)

    async def watch_distance(self, robot: str, distance: float, report: Reporter) -> str:
        """See `MobileRobots`."""
        watch = f"watch-{next(self._ids)}"
        self._reporters[watch] = report
        request = wire.WatchDistance(id=watch, robot=robot, distance=distance)
        return await self._ask_reported(wire.WATCH_DISTANCE, request, watch)

    async def cancel_watch(self, watch: str) -> None:
        """See `MobileRobots`."""
        await self._forget(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)

    # -------------------------------------------------------- simulation

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """See `Simulation`."""
        try:
            text = self._models.read(model)
        except ModelNotFound as error:
            raise BackendRefused(str(error), wire.SpawnResult.NO_RESOURCE) from error
        request = wire.SpawnEntity(
            name=name, uri=model, resource_string=text, initial_pose=_pose(pose), allow_renaming=allow_renaming
        )
        return (await self._ask(wire.SPAWN_ENTITY, request)).name

    async def relative_pose(self, frame: str, parent_frame: str, distance: float) -> Pose3D:
        """See `Simulation`."""
        request = wire.RelativePose(frame=frame, parent_frame=parent_frame, distance=distance)
        pose = await self._ask(wire.GET_RELATIVE_POSE, request)
        return Pose3D(
            Position3D(pose.position.x, pose.position.y, pose.position.z),
            Orientation3D(pose.orientation.roll, pose.orientation.pitch, pose.orientation.yaw),
        )

    async def delete_entity(self, name: str) -> None:
        """See `Simulation`."""
        await self._ask(wire.DELETE_ENTITY, wire.EntityName(name=name))

    async def entities(self) -> tuple[str, ...]:
        """See `Simulation`."""
        return (await self._ask(wire.GET_ENTITIES, wire.EntityFilter())).names

    async def set_entity_state(self, name: str, pose: Pose3D, velocity: Velocity6D) -> None:
        """See `Simulation`."""
        linear, angular = velocity.translational, velocity.angular
        twist = wire.Twist(
            linear=wire.Vector3(x=linear.x, y=linear.y, z=linear.z),
            angular=wire.Vector3(x=angular.roll, y=angular.pitch, z=angular.yaw),
        )
        await self._ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=name, pose=_pose(pose), twist=twist))

    async def step_simulation(self, steps: int) -> None:
        """See `Simulation`."""
        await self._ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=steps))

    async def reset_simulation(self) -> None:
        """See `Simulation`. The simulator's clock is that of the run, and is left alone."""
        scope = wire.ResetScope.STATE | wire.ResetScope.SPAWNED
        await self._ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))

    # -------------------------------------------------------- requests

    async def load_world(self, world: str, seed: int) -> None:
        """Load a world, at time zero; who lives where is open again."""
        self._features = await self._ask(wire.LOAD_WORLD, wire.LoadWorld(world=world, seed=seed), GRANT_TIMEOUT)
        self._taken.clear()

    async def _ask(
        self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
    ) -> wire.A:
        if self._lost_reason is not None:
            raise BackendLost(self._lost_reason)
        try:
            return await ask(self._address, verb, request, timeout)
        except BackendLost as error:
            # Whoever watches the node knows better why, and is about to say so.
            with anyio.move_on_after(LOSS_NOTICE):
                await self._gone.wait()
            raise BackendLost(self._lost_reason or str(error)) from error

    async def _ask_reported(self, verb: wire.Verb[wire.Q, wire.Empty], request: wire.Q, number: str) -> str:
        try:
            await self._ask(verb, request)
        except BaseException:
            self._reporters.pop(number, None)
            raise
        return number

    async def _forget(self, verb: wire.Verb[wire.Q, wire.Empty], request: wire.Q, number: str) -> None:
        self._reporters.pop(number, None)
        try:
            await self._ask(verb, request)
        except BackendRefused as error:
            if error.code != wire.Result.NOT_FOUND:  # it has ended by itself in the meantime
                raise


async def ask(
    address: NodeAddress, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
) -> wire.A:
    """Ask a node to carry out a verb.

    Raises:
        BackendRefused: It said no.
        BackendLost: It is gone, does not answer, or what it answers is no valid message.
    """
    key = wire.node_command(address.namespace, address.node, verb.name)
    called = f"the simulator node '{address.node}'"
    try:
        return wire.decode(verb.answer, await address.session.query(key, wire.encode(request), timeout))
    except Refused as refused:
        refusal = _refusal(refused.payload)
        raise BackendRefused(refusal.message, refusal.code) from None
    except NoServer:
        raise BackendLost(f"{called} is gone") from None
    except NoAnswer:
        raise BackendLost(f"{called} did not answer `{verb.name}` in {timeout:g} s") from None
    except SessionError as error:
        raise BackendLost(f"{called} cannot be asked: {error}") from error
    except wire.WireError as error:
        raise BackendLost(f"{called} sent an answer that is none: {error}") from error


def _refusal(payload: bytes) -> wire.Refusal:
    try:
        return wire.decode(wire.Refusal, payload)
    except wire.WireError:
        return wire.Refusal(code=wire.Result.OPERATION_FAILED, message=payload[:200].decode(errors="replace"))


def _vector(position: Position3D) -> wire.Vector3:
    return wire.Vector3(x=position.x, y=position.y, z=position.z)


def _pose(pose: Pose3D) -> wire.Pose:
    turned = pose.orientation
    return wire.Pose(
        position=_vector(pose.position),
        orientation=wire.Orientation(roll=turned.roll, pitch=turned.pitch, yaw=turned.yaw),
    )


def _ignore(name: str, arguments: Mapping[str, object]) -> None:
    """Before a run has started nobody listens."""


def _ignore_loss(reason: str) -> None:
    """Before a run has started nobody listens; the reason is kept."""
