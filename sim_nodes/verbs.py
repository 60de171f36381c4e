"""The verbs of `seoro.bridges.wire`, each as a function of a simulator and a request."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import MappingProxyType
from typing import Any

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from sim_nodes.geometry import Pose2
from sim_nodes.messages import body_state, check_pose, entity_state, flat_pose, planar
from sim_nodes.navigation.navigator import Goal
from sim_nodes.physics import UnstablePhysics
from sim_nodes.refusal import RequestRefused, listed
from sim_nodes.sdf import parse_model
from sim_nodes.simulator import Simulator

MAX_POSES = 100
MAX_ID = 200  # [characters]
MAX_SPEED = 100.0  # [m/s], [rad/s]

Handler = Callable[[Simulator, Any], wire.Message]


def handle(simulator: Simulator, verb: str, payload: bytes) -> bytes:
    """Carry out a request.

    Args:
        simulator: Who carries it out.
        verb: Name of the verb.
        payload: The encoded request.

    Returns:
        The encoded answer.

    Raises:
        RequestRefused: It cannot be carried out.
    """
    if verb not in VERBS:
        raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"there is no verb {verb!r}: known are {listed(VERBS)}")
    model, handler = VERBS[verb]
    try:
        request = wire.decode(model, payload)
    except wire.WireError as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
    try:
        return wire.encode(handler(simulator, request))
    except UnstablePhysics as error:
        raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error


# ---------------------------------------------------------------- simulator


def _get_simulator_features(simulator: Simulator, _: Empty) -> wire.SimulatorFeatures:
    return simulator.features()


def _load_world(simulator: Simulator, request: wire.LoadWorld) -> wire.SimulatorFeatures:
    simulator.load(request.world, request.seed)
    return simulator.features()


def _set_simulation_state(simulator: Simulator, request: wire.SetSimulationState) -> Empty:
    simulator.set_state(request.state)
    return Empty()


def _step_simulation(simulator: Simulator, request: wire.StepSimulation) -> wire.SimulationTime:
    return wire.SimulationTime(time=simulator.step(request.steps))


def _reset_simulation(simulator: Simulator, request: wire.ResetSimulation) -> Empty:
    simulator.reset(request.scope)
    return Empty()


def _advance(simulator: Simulator, request: wire.Advance) -> wire.Advanced:
    return simulator.advance(request.until)


# ---------------------------------------------------------------- entities


def _spawn_entity(simulator: Simulator, request: wire.SpawnEntity) -> wire.EntityName:
    check_pose(request.initial_pose, wire.SpawnResult.INVALID_POSE)
    if not request.resource_string.strip():
        raise RequestRefused(wire.SpawnResult.NO_RESOURCE, f"the model {request.uri!r} is empty")
    try:
        model = parse_model(request.resource_string)
    except RequestRefused as error:
        raise RequestRefused(error.code, f"{request.uri}: {error.message}") from error
    simulation = simulator.simulation
    state = body_state(request.initial_pose)
    name = simulation.entities.spawn(request.name, model, state, simulation.time, rename=request.allow_renaming)
    return wire.EntityName(name=name)


def _delete_entity(simulator: Simulator, request: wire.EntityName) -> Empty:
    simulator.simulation.entities.delete(request.name)
    return Empty()


def _get_entities(simulator: Simulator, request: wire.EntityFilter) -> wire.Entities:
    return wire.Entities(names=simulator.simulation.entities.matching(request.filter))


def _get_entity_state(simulator: Simulator, request: wire.EntityName) -> wire.EntityState:
    return entity_state(simulator.simulation.entities.state(request.name))


def _set_entity_state(simulator: Simulator, request: wire.SetEntityState) -> Empty:
    entities = simulator.simulation.entities
    present = entity_state(entities.state(request.name))
    pose = request.pose or present.pose
    check_pose(pose, Result.OPERATION_FAILED)
    twist = request.twist or present.twist
    speeds = (*twist.linear.model_dump().values(), *twist.angular.model_dump().values())
    if not all(abs(speed) <= MAX_SPEED for speed in speeds):
        raise RequestRefused(
            Result.OPERATION_FAILED, f"the twist {speeds} has a part that is no number up to {MAX_SPEED:g}"
        )
    entities.move(request.name, body_state(pose, twist))
    return Empty()


# ---------------------------------------------------------------- robots


def _set_initial_pose(simulator: Simulator, request: wire.SetInitialPose) -> Empty:
    simulator.simulation.set_initial_pose(request.robot, planar(request.pose))
    return Empty()


def _navigate_through_poses(simulator: Simulator, request: wire.NavigateThroughPoses) -> Empty:
    _check_id(request.id)
    if not 1 <= len(request.poses) <= MAX_POSES:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"{len(request.poses)} poses were given: give 1 to {MAX_POSES}"
        )
    poses = tuple(planar(pose) for pose in request.poses)
    simulator.simulation.navigate(request.robot, Goal(request.id, poses, request.stop_at_each))
    return Empty()


def _cancel_goal(simulator: Simulator, request: wire.CancelGoal) -> Empty:
    simulator.simulation.cancel_goal(request.id)
    return Empty()


def _stop_robot(simulator: Simulator, request: wire.StopRobot) -> Empty:
    simulator.simulation.stop_robot(request.robot)
    return Empty()


def _watch_proximity(simulator: Simulator, request: wire.WatchProximity) -> Empty:
    _check_id(request.id)
    point = (request.point.x, request.point.y)
    _check_finite("point", *point)
    _check_length("threshold", request.threshold)
    simulator.simulation.watch_proximity(request.id, request.frame, request.parent_frame, point, request.threshold)
    return Empty()


def _watch_distance(simulator: Simulator, request: wire.WatchDistance) -> Empty:
    _check_id(request.id)
    _check_length("distance", request.distance)
    simulator.simulation.watch_distance(request.id, request.robot, request.distance)
    return Empty()


def _cancel_watch(simulator: Simulator, request: wire.CancelWatch) -> Empty:
    simulator.simulation.cancel_watch(request.id)
    return Empty()


def _get_relative_pose(simulator: Simulator, request: wire.RelativePose) -> wire.Pose:
    _check_finite("distance", request.distance)
    poses = []
    for name in (request.frame, request.parent_frame):
        pose = simulator.simulation.frame(name)()
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE, f"the frame {name!r} has no pose yet: set the robot's initial pose first"
            )
        poses.append(pose)
    frame, parent = poses
    return flat_pose(parent.inverse().compose(frame).compose(Pose2(request.distance, 0.0, 0.0)))


def _get_artifacts(simulator: Simulator, _: Empty) -> wire.Artifacts:
    # Half a second of imports that a node needs only when it is asked for pictures.
    from sim_nodes.picture import top_down  # noqa: PLC0415

    simulation = simulator.simulation
    picture = wire.Artifact(
        name="top_down.png",
        media_type="image/png",
        description=f"The world {simulation.world.name} from above, with the paths that its robots drove",
        data=top_down(simulation),
    )
    return wire.Artifacts(artifacts=(picture,))


# ---------------------------------------------------------------- checks


def _check_id(identifier: str) -> None:
    if not 1 <= len(identifier) <= MAX_ID:
        raise RequestRefused(Result.OPERATION_FAILED, f"an id has 1 to {MAX_ID} characters, not {len(identifier)}")


def _check_finite(what: str, *values: float) -> None:
    if not all(math.isfinite(value) for value in values):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} {values} has a part that is no finite number")


def _check_length(what: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise RequestRefused(Result.OPERATION_FAILED, f"the {what} is {value}: it has to be more than 0 m")


VERBS: MappingProxyType[str, tuple[type[wire.Message], Handler]] = MappingProxyType(
    {
        verb.name: (verb.request, handler)
        for verb, handler in (
            (wire.GET_SIMULATOR_FEATURES, _get_simulator_features),
            (wire.LOAD_WORLD, _load_world),
            (wire.SPAWN_ENTITY, _spawn_entity),
            (wire.DELETE_ENTITY, _delete_entity),
            (wire.GET_ENTITIES, _get_entities),
            (wire.GET_ENTITY_STATE, _get_entity_state),
            (wire.SET_ENTITY_STATE, _set_entity_state),
            (wire.SET_SIMULATION_STATE, _set_simulation_state),
            (wire.STEP_SIMULATION, _step_simulation),
            (wire.RESET_SIMULATION, _reset_simulation),
            (wire.ADVANCE, _advance),
            (wire.SET_INITIAL_POSE, _set_initial_pose),
            (wire.NAVIGATE_THROUGH_POSES, _navigate_through_poses),
            (wire.CANCEL_GOAL, _cancel_goal),
            (wire.STOP_ROBOT, _stop_robot),
            (wire.WATCH_PROXIMITY, _watch_proximity),
            (wire.WATCH_DISTANCE, _watch_distance),
            (wire.CANCEL_WATCH, _cancel_watch),
            (wire.GET_RELATIVE_POSE, _get_relative_pose),
            (wire.GET_ARTIFACTS, _get_artifacts),
        )
    }
)
