"""Verbs about robots: goals, velocities, localisation and frames of wheeled ones, arms and grippers."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import check_drive_duration, check_finite, check_positive
from sim_nodes.geometry import Array, Pose2, quaternion_of, rotation_matrix
from sim_nodes.manipulation.arm import MotionOptions
from sim_nodes.manipulation.chain import pose_matrix
from sim_nodes.manipulation.gripper import GripperGoal
from sim_nodes.messages import body_state, check_pose, feedback_message, flat_pose, planar, pose_of
from sim_nodes.navigation.goals import Goal
from sim_nodes.outcomes import incorrect_state, operation_failed
from sim_nodes.physics import BodyState
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.simulator import Simulator
from sim_nodes.watches import DistanceWatch, JointWatch, LocalisationWatch, ProximityWatch

MAX_POSES = 100
MAX_PERIOD = 3600.0  # [s]


def set_initial_pose(simulator: Simulator, request: wire.SetInitialPose) -> None:
    simulation = simulator.simulation
    simulation.robot(request.robot).mobile.set_initial_pose(planar(request.pose), simulation.tick)


def navigate_through_poses(simulator: Simulator, request: wire.NavigateThroughPoses) -> None:
    if not 1 <= len(request.poses) <= MAX_POSES:
        raise operation_failed(f"found {len(request.poses)} poses; expected 1 to {MAX_POSES}")
    poses = tuple(planar(pose) for pose in request.poses)
    if not 0.0 <= request.feedback_period <= MAX_PERIOD:
        raise operation_failed(
            f"invalid feedback period {request.feedback_period} s; expected 0 (none) to {MAX_PERIOD:g} s"
        )
    goal = Goal(request.id, poses, request.stop_at_each, request.feedback_period)
    simulator.simulation.navigate(request.robot, goal)


def get_navigation_feedback(simulator: Simulator, request: wire.RobotName) -> wire.NavigationFeedback:
    simulation, robot = simulator.simulation, request.robot
    return feedback_message(robot, simulation.time, simulation.robot(robot).mobile.feedback())


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
            raise incorrect_state(f"the frame {name!r} has no pose yet; set the robot's initial pose first")
        poses.append(pose)
    frame, parent = poses
    relative = flat_pose(parent.inverse().compose(frame).compose(Pose2(request.distance, 0.0, 0.0)))
    return wire.FramePose(position=relative.position, orientation=relative.orientation)


def drive(simulator: Simulator, request: wire.Drive) -> None:
    velocity = Velocity(request.linear, request.angular, request.lateral)
    check_finite("velocity", *velocity)
    check_drive_duration(request.duration)
    simulator.simulation.drive(request.robot, request.id, velocity, request.duration)


def follow_path(simulator: Simulator, request: wire.FollowPath) -> None:
    points = [(point.x, point.y) for point in request.points]
    check_finite("points", *(value for point in points for value in point))
    if not 1 <= len(points) <= MAX_POSES:
        raise operation_failed(f"found {len(points)} points of a path; expected 1 to {MAX_POSES}")
    if request.speed != 0.0:
        check_positive("speed", request.speed, "m/s")
    simulator.simulation.follow_path(request.robot, request.id, points, request.speed, repeat=request.repeat)


def cmd_vel(simulator: Simulator, request: wire.CmdVel) -> None:
    linear, angular = request.twist.linear, request.twist.angular
    check_finite("twist", linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    if any((linear.z, angular.x, angular.y)):
        raise operation_failed("unsupported twist of a base; expected only linear x and y, and angular z")
    simulator.simulation.command_velocity(request.robot, Velocity(linear.x, angular.z, linear.y))


def reinitialize_global_localization(simulator: Simulator, request: wire.RobotName) -> None:
    simulator.simulation.robot(request.robot).mobile.search_pose(simulator.simulation.tick)


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
    truth = simulation.frames.true_pose(request.robot)
    return wire.Localization(
        pose=flat_pose(pose),
        covariance=tuple(estimate.covariance.ravel().tolist()),
        particles=len(base.localisation.particles),
        error=pose.distance(truth.x, truth.y),
    )


MIN_SCALING = 1e-3  # minimum share of the speed
LONGEST = 86_400.0  # [s] maximum duration of holding


def follow_joint_trajectory(simulator: Simulator, request: wire.FollowJointTrajectory) -> None:
    arm = simulator.simulation.arm_for_goal(request.robot, request.id)
    arm.follow(request.id, request.points, request.joint_names, _manner(request))


def take_posture(simulator: Simulator, request: wire.TakePosture) -> None:
    arm = simulator.simulation.arm_for_goal(request.robot, request.id)
    arm.take_posture(request.id, request.posture, _manner(request))


def move_to_pose(simulator: Simulator, request: wire.MoveToPose) -> None:
    arm = simulator.simulation.arm_for_goal(request.robot, request.id)
    target = arm.in_map(_matrix(request.pose), request.frame)
    move = arm.move_straight if request.straight else arm.move_to_pose
    move(request.id, target, _manner(request))


def gripper_command(simulator: Simulator, request: wire.GripperCommand) -> None:
    check_finite("command", request.opening, request.force or 0.0)
    _check_manner(request.max_velocity_scaling_factor, request.tolerance)
    gripper = simulator.simulation.arm_for_goal(request.robot, request.id).gripper
    force = gripper.usual_force if request.force is None else request.force
    scaling = request.max_velocity_scaling_factor
    gripper.command(GripperGoal(request.id, request.opening, force, scaling, request.tolerance))


def hold_entity(simulator: Simulator, request: wire.HoldEntity) -> None:
    if not 0.0 <= request.duration <= LONGEST:
        raise operation_failed(f"invalid duration {request.duration} s; expected 0 to {LONGEST:g} s")
    arm = simulator.simulation.arm_for_goal(request.robot, request.id)
    arm.hold(request.id, request.entity, request.duration, simulator.simulation.tick)


def get_joint_states(simulator: Simulator, request: wire.RobotName) -> wire.JointStates:
    arm = simulator.simulation.robot(request.robot).arm
    states = arm.states()
    return wire.JointStates(
        names=arm.joints,
        positions=tuple(states.positions.tolist()),
        velocities=tuple(states.velocities.tolist()),
        efforts=tuple(states.efforts.tolist()),
    )


def get_arm_state(simulator: Simulator, request: wire.RobotName) -> wire.ArmState:
    arm = simulator.simulation.robot(request.robot).arm
    pose = arm.tool_pose()
    x, y, z = pose[:3, 3].tolist()
    return wire.ArmState(
        tool=pose_of(BodyState((x, y, z), quaternion_of(pose[:3, :3]))),
        opening=arm.gripper.opening() if arm.has_gripper else 0.0,
        held=arm.held or "",
        remaining=arm.remaining,
    )


def watch_joint(simulator: Simulator, request: wire.WatchJoint) -> None:
    check_finite("position", request.position)
    _check_manner(1.0, request.tolerance)
    simulation, robot, joint, target = simulator.simulation, request.robot, request.joint, request.position
    from_above = simulation.joint_position(robot, joint) > target
    simulation.watch(request.id, JointWatch(robot, joint, target, request.tolerance, from_above))


def _manner(request: wire.ArmMotion) -> MotionOptions:
    scaling, tolerance = request.max_velocity_scaling_factor, request.tolerance
    _check_manner(scaling, tolerance)
    return MotionOptions(scaling, tolerance, frozenset(request.may_touch), request.plan_only)


def _check_manner(scaling: float, tolerance: float) -> None:
    if not MIN_SCALING <= scaling <= 1.0:
        raise operation_failed(f"invalid velocity scaling factor {scaling:g}; expected {MIN_SCALING:g} to 1")
    check_positive("tolerance", tolerance)


def _matrix(pose: wire.Pose3D) -> Array:
    check_pose(pose, Result.OPERATION_FAILED)
    state = body_state(pose)
    return pose_matrix(state.position, rotation_matrix(state.orientation))
