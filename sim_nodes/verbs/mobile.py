"""Verbs about robots that drive, and about frames."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_id, check_positive
from sim_nodes.geometry import Pose2
from sim_nodes.messages import flat_pose, planar
from sim_nodes.navigation.navigator import Goal
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling
from sim_nodes.watches import DistanceWatch, ProximityWatch

MAX_POSES = 100
MAX_PERIOD = 3600.0  # [s]


def _set_initial_pose(simulator: Simulator, request: wire.SetInitialPose) -> Empty:
    simulator.simulation.set_initial_pose(request.robot, planar(request.pose))
    return Empty()


def _navigate_through_poses(simulator: Simulator, request: wire.NavigateThroughPoses) -> Empty:
    check_id(request.id)
    if not 1 <= len(request.poses) <= MAX_POSES:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"{len(request.poses)} poses were given: give 1 to {MAX_POSES}"
        )
    poses = tuple(planar(pose) for pose in request.poses)
    if not 0.0 <= request.feedback_period <= MAX_PERIOD:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the period of feedback is {request.feedback_period} s: give 0 for none, {MAX_PERIOD:g} s at most",
        )
    goal = Goal(request.id, poses, request.stop_at_each, request.feedback_period)
    simulator.simulation.navigate(request.robot, goal)
    return Empty()


def _get_navigation_feedback(simulator: Simulator, request: wire.FeedbackRequest) -> wire.NavigationFeedback:
    return simulator.simulation.feedback(request.robot)


def _stop_robot(simulator: Simulator, request: wire.StopRobot) -> Empty:
    simulator.simulation.stop_robot(request.robot)
    return Empty()


def _watch_proximity(simulator: Simulator, request: wire.WatchProximity) -> Empty:
    check_id(request.id)
    point = (request.point.x, request.point.y)
    check_finite("point", *point)
    check_positive("threshold", request.threshold, "m")
    simulation = simulator.simulation
    frame, parent = (simulation.frames.own(name, request.robot) for name in (request.frame, request.parent_frame))
    watch = ProximityWatch(frame, parent, *point, request.threshold)
    simulation.watch(request.id, watch)
    return Empty()


def _watch_distance(simulator: Simulator, request: wire.WatchDistance) -> Empty:
    check_id(request.id)
    check_positive("distance", request.distance, "m")
    simulation = simulator.simulation
    target = simulation.travelled(request.robot) + request.distance
    simulation.watch(request.id, DistanceWatch(request.robot, target))
    return Empty()


def _get_relative_pose(simulator: Simulator, request: wire.RelativePose) -> wire.Pose:
    check_finite("distance", request.distance)
    poses = []
    for name in (request.frame, request.parent_frame):
        simulator.simulation.frames.check(name)
        pose = simulator.simulation.pose(name)
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE, f"the frame {name!r} has no pose yet: set the robot's initial pose first"
            )
        poses.append(pose)
    frame, parent = poses
    return flat_pose(parent.inverse().compose(frame).compose(Pose2(request.distance, 0.0, 0.0)))


HANDLERS: tuple[Handling, ...] = (
    (wire.SET_INITIAL_POSE, _set_initial_pose),
    (wire.NAVIGATE_THROUGH_POSES, _navigate_through_poses),
    (wire.GET_NAVIGATION_FEEDBACK, _get_navigation_feedback),
    (wire.STOP_ROBOT, _stop_robot),
    (wire.WATCH_PROXIMITY, _watch_proximity),
    (wire.WATCH_DISTANCE, _watch_distance),
    (wire.GET_RELATIVE_POSE, _get_relative_pose),
)
