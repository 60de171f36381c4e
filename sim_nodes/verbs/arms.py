"""Verbs about arms and grippers."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_id, check_positive
from sim_nodes.geometry import Array, quaternion_of, rotation_matrix
from sim_nodes.manipulation.arm import Manner
from sim_nodes.manipulation.chain import pose_matrix
from sim_nodes.manipulation.gripper import GripperGoal
from sim_nodes.messages import body_state, check_pose, pose_of
from sim_nodes.physics import BodyState
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling
from sim_nodes.watches import JointWatch

MIN_SCALING = 1e-3  # of the speed
LONGEST = 86_400.0  # [s] for which something may be asked to be held


def _follow_joint_trajectory(simulator: Simulator, request: wire.FollowJointTrajectory) -> Empty:
    check_id(request.id)
    arm = simulator.simulation.arm_of(request.robot, request.id)
    arm.follow(request.id, request.points, request.joint_names, _manner(request))
    return Empty()


def _move_to_pose(simulator: Simulator, request: wire.MoveToPose) -> Empty:
    check_id(request.id)
    arm = simulator.simulation.arm_of(request.robot, request.id)
    target = arm.in_map(_matrix(request.pose), request.frame)
    move = arm.move_straight if request.straight else arm.move_to_pose
    move(request.id, target, _manner(request))
    return Empty()


def _gripper_command(simulator: Simulator, request: wire.GripperCommand) -> Empty:
    check_id(request.id)
    check_finite("command", request.opening, request.force or 0.0)
    _check_manner(request.max_velocity_scaling_factor, request.tolerance)
    gripper = simulator.simulation.arm_of(request.robot, request.id).gripper
    force = gripper.usual_force if request.force is None else request.force
    scaling = request.max_velocity_scaling_factor
    gripper.command(GripperGoal(request.id, request.opening, force, scaling, request.tolerance))
    return Empty()


def _hold_entity(simulator: Simulator, request: wire.HoldEntity) -> Empty:
    check_id(request.id)
    if not 0.0 <= request.duration <= LONGEST:
        raise RequestRefused(
            Result.OPERATION_FAILED, f"the duration is {request.duration} s: it has to be 0 to {LONGEST:g} s"
        )
    simulator.simulation.hold_entity(request.robot, request.id, request.entity, request.duration)
    return Empty()


def _get_joint_states(simulator: Simulator, request: wire.RobotName) -> wire.JointStates:
    arm = simulator.simulation.robot(request.robot).arm
    states = arm.states()
    return wire.JointStates(
        names=arm.joints,
        positions=tuple(states.positions.tolist()),
        velocities=tuple(states.velocities.tolist()),
        efforts=tuple(states.efforts.tolist()),
    )


def _get_arm_state(simulator: Simulator, request: wire.RobotName) -> wire.ArmState:
    arm = simulator.simulation.robot(request.robot).arm
    pose = arm.tool_pose()
    x, y, z = pose[:3, 3].tolist()
    return wire.ArmState(
        tool=pose_of(BodyState((x, y, z), quaternion_of(pose[:3, :3]))),
        opening=arm.gripper.opening(),
        held=arm.gripper.held or "",
        remaining=arm.remaining,
    )


def _watch_joint(simulator: Simulator, request: wire.WatchJoint) -> Empty:
    check_id(request.id)
    check_finite("position", request.position)
    _check_manner(1.0, request.tolerance)
    simulation, robot, joint, target = simulator.simulation, request.robot, request.joint, request.position
    from_above = simulation.joint_position(robot, joint) > target
    simulation.watch(request.id, JointWatch(robot, joint, target, request.tolerance, from_above))
    return Empty()


def _manner(request: wire.ArmMotion) -> Manner:
    scaling, tolerance = request.max_velocity_scaling_factor, request.tolerance
    _check_manner(scaling, tolerance)
    return Manner(scaling, tolerance, frozenset(request.may_touch), request.plan_only)


def _check_manner(scaling: float, tolerance: float) -> None:
    if not MIN_SCALING <= scaling <= 1.0:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the velocity scaling factor is {scaling:g}: it is {MIN_SCALING:g} to 1",
        )
    check_positive("tolerance", tolerance)


def _matrix(pose: wire.Pose) -> Array:
    check_pose(pose, Result.OPERATION_FAILED)
    state = body_state(pose)
    return pose_matrix(state.position, rotation_matrix(state.orientation))


HANDLERS: tuple[Handling, ...] = (
    (wire.FOLLOW_JOINT_TRAJECTORY, _follow_joint_trajectory),
    (wire.MOVE_TO_POSE, _move_to_pose),
    (wire.GRIPPER_COMMAND, _gripper_command),
    (wire.HOLD_ENTITY, _hold_entity),
    (wire.GET_JOINT_STATES, _get_joint_states),
    (wire.GET_ARM_STATE, _get_arm_state),
    (wire.WATCH_JOINT, _watch_joint),
)
