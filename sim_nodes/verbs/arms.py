"""Verbs about arms and grippers."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive
from sim_nodes.geometry import Array, quaternion_of, rotation_matrix
from sim_nodes.manipulation.arm import MotionOptions
from sim_nodes.manipulation.chain import pose_matrix
from sim_nodes.manipulation.gripper import GripperGoal
from sim_nodes.messages import body_state, check_pose, pose_of
from sim_nodes.physics import BodyState
from sim_nodes.simulator import Simulator
from sim_nodes.watches import JointWatch

MIN_SCALING = 1e-3  # minimum share of the speed
LONGEST = 86_400.0  # [s] maximum duration of holding


def follow_joint_trajectory(simulator: Simulator, request: wire.FollowJointTrajectory) -> None:
    arm = simulator.simulation.arm_for_goal(request.robot, request.id)
    arm.follow(request.id, request.points, request.joint_names, _manner(request))


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
        raise RequestRefused(
            Result.OPERATION_FAILED, f"invalid duration {request.duration} s; expected 0 to {LONGEST:g} s"
        )
    simulator.simulation.hold_entity(request.robot, request.id, request.entity, request.duration)


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
        opening=arm.gripper.opening(),
        held=arm.gripper.held or "",
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
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid velocity scaling factor {scaling:g}; expected {MIN_SCALING:g} to 1",
        )
    check_positive("tolerance", tolerance)


def _matrix(pose: wire.Pose3D) -> Array:
    check_pose(pose, Result.OPERATION_FAILED)
    state = body_state(pose)
    return pose_matrix(state.position, rotation_matrix(state.orientation))
