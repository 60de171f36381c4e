"""Verbs about wheeled robots: goals, velocities, localisation and frames."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_drive_duration, check_finite, check_positive
from sim_nodes.geometry import Pose2
from sim_nodes.messages import flat_pose, planar
from sim_nodes.navigation.navigator import Goal
from sim_nodes.robots.diff_drive import Velocity
from sim_nodes.simulator import Simulator
from sim_nodes.watches import DistanceWatch, LocalisationWatch, ProximityWatch

MAX_POSES = 100
MAX_PERIOD = 3600.0  # [s]


def set_initial_pose(simulator: Simulator, request: wire.SetInitialPose) -> None:
    simulator.simulation.set_initial_pose(request.robot, planar(request.pose))


def navigate_through_poses(simulator: Simulator, request: wire.NavigateThroughPoses) -> None:
    if not 1 <= len(request.poses) <= MAX_POSES:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"found {len(request.poses)} poses; expected 1 to {MAX_POSES}"
        )
    poses = tuple(planar(pose) for pose in request.poses)
    if not 0.0 <= request.feedback_period <= MAX_PERIOD:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid feedback period {request.feedback_period} s; expected 0 (none) to {MAX_PERIOD:g} s",
        )
    goal = Goal(request.id, poses, request.stop_at_each, request.feedback_period)
    simulator.simulation.navigate(request.robot, goal)


def get_navigation_feedback(simulator: Simulator, request: wire.RobotName) -> wire.NavigationFeedback:
    return simulator.simulation.feedback(request.robot)


def stop_robot(simulator: Simulator, request: wire.StopRobot) -> None:
    simulator.simulation.stop_robot(request.robot)


def watch_proximity(simulator: Simulator, request: wire.WatchProximity) -> None:
    point = (request.point.x, request.point.y)
    check_finite("point", *point)
    check_positive("threshold", request.threshold, "m")
    simulation = simulator.simulation
    frame, parent = (simulation.frames.own(name, request.robot) for name in (request.frame, request.parent_frame))
    watch = ProximityWatch(frame, parent, *point, request.threshold)
    simulation.watch(request.id, watch)


def watch_distance(simulator: Simulator, request: wire.WatchDistance) -> None:
    check_positive("distance", request.distance, "m")
    simulation = simulator.simulation
    target = simulation.travelled(request.robot) + request.distance
    simulation.watch(request.id, DistanceWatch(request.robot, target))


def get_relative_pose(simulator: Simulator, request: wire.RelativePose) -> wire.FramePose:
    check_finite("distance", request.distance)
    poses = []
    for name in (request.frame, request.parent_frame):
        simulator.simulation.frames.check(name)
        pose = simulator.simulation.pose(name)
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"the frame {name!r} has no pose yet; set the robot's initial pose first",
            )
        poses.append(pose)
    frame, parent = poses
    relative = flat_pose(parent.inverse().compose(frame).compose(Pose2(request.distance, 0.0, 0.0)))
    return wire.FramePose(position=relative.position, orientation=relative.orientation)


def drive(simulator: Simulator, request: wire.Drive) -> None:
    velocity = Velocity(request.linear, request.angular)
    check_finite("velocity", *velocity)
    check_drive_duration(request.duration)
    simulator.simulation.drive(request.robot, request.id, velocity, request.duration)


def cmd_vel(simulator: Simulator, request: wire.CmdVel) -> None:
    linear, angular = request.twist.linear, request.twist.angular
    check_finite("twist", linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    if any((linear.y, linear.z, angular.x, angular.y)):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            "unsupported twist of a differential drive; expected only linear x and angular z",
        )
    simulator.simulation.command_velocity(request.robot, Velocity(linear.x, angular.z))


def reinitialize_global_localization(simulator: Simulator, request: wire.RobotName) -> None:
    simulator.simulation.search_pose(request.robot)


def watch_localization(simulator: Simulator, request: wire.WatchLocalization) -> None:
    simulation = simulator.simulation
    simulation.watch(request.id, LocalisationWatch(simulation.robot(request.robot).mobile.name))


def get_localization(simulator: Simulator, request: wire.RobotName) -> wire.Localization:
    simulation = simulator.simulation
    base = simulation.robot(request.robot).mobile
    pose, estimate = base.localised_pose(), base.localisation.estimate
    if pose is None or estimate is None:
        return wire.Localization(
            pose=None, covariance=None, particles=len(base.localisation.particles), error=None
        )
    truth = simulation.true_pose(request.robot)
    return wire.Localization(
        pose=flat_pose(pose),
        covariance=tuple(estimate.covariance.ravel().tolist()),
        particles=len(base.localisation.particles),
        error=pose.distance(truth.x, truth.y),
    )
