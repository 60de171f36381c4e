"""Motors of position-controlled joints, derived from a model.

The motor of a joint with effort limit F [N m], [N] has its full effort at an error of `FULL_EFFORT`: its
stiffness is k = F / FULL_EFFORT. The inertia I about the joint is that of the moved links, as points at their
centres of mass. All joints are at zero for it. For a joint that slides, I is their mass. The armature a keeps the
natural frequency sqrt(k / (I + a)) at `FREQUENCY` or less, at which steps of 5 ms are stable. Damping is critical:
2 sqrt(k (I + a)).
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.robots.declaration import JointDeclaration
from sim_nodes.robots.derive.model import ModelJoint, RobotModel

FULL_EFFORT = {False: 0.05, True: 0.02}  # [rad] of joints that turn, [m] of sliding ones
FREQUENCY = 100.0  # [rad/s]
LEAST_ARMATURE = 1e-3  # [kg m^2], [kg]
ACCELERATIONS = {False: (1.0, 10.0), True: (0.5, 5.0)}  # [rad/s^2], [m/s^2]
SPEED = {False: 2.0, True: 0.2}  # [rad/s], [m/s] of joints without a limit
TURN = 2.0 * math.pi  # [rad] limit of joints that turn freely
GRAVITY = 9.81  # [m/s^2]
DIGITS = 6


def limits_of(joint: ModelJoint) -> tuple[float, float]:
    """Return the lower and upper limit of a joint that turns or slides [rad], [m]."""
    return (-TURN, TURN) if math.isinf(joint.lower) or math.isinf(joint.upper) else (joint.lower, joint.upper)


def speed_of(joint: ModelJoint) -> float:
    """Return the speed limit of a joint: that of the model, or `SPEED` [rad/s], [m/s]."""
    return SPEED[joint.slides] if math.isinf(joint.velocity) else joint.velocity


def effort_of(model: RobotModel, joint: ModelJoint, *, carries_body: bool) -> float:
    """Return the effort limit: that of the model, or twice what the weight of its links needs [N m], [N].

    Args:
        model: Model of the robot.
        joint: A joint of it.
        carries_body: Whether it carries the weight of the robot, such as that of a leg.
    """
    if math.isfinite(joint.effort):
        return joint.effort
    links = _moved_links(model, joint)
    if joint.slides:
        weight = GRAVITY * (model.mass if carries_body else sum(model.masses[link] for link in links))
        return max(10.0, round(2.0 * weight, DIGITS))
    origin = np.array(model.frames[joint.child][0])
    arms = {link: float(np.linalg.norm(np.array(model.centres[link]) - origin)) for link in links}
    if carries_body:
        return max(1.0, round(GRAVITY * model.mass * max(arms.values()), DIGITS))
    return max(1.0, round(2.0 * GRAVITY * sum(model.masses[link] * arms[link] for link in links), DIGITS))


def declare_motor(model: RobotModel, joint: ModelJoint, home: float, effort: float) -> JointDeclaration:
    """Declare the motor of a joint, by its initial position [rad], [m] and its effort limit [N m], [N]."""
    inertia, stiffness = _inertia(model, joint), effort / FULL_EFFORT[joint.slides]
    armature = max(LEAST_ARMATURE, stiffness / FREQUENCY**2 - inertia)
    low, high = ACCELERATIONS[joint.slides]
    return JointDeclaration(
        name=joint.name,
        home=home,
        max_acceleration=round(min(high, max(low, effort / (2.0 * (inertia + armature)))), DIGITS),
        stiffness=round(stiffness, DIGITS),
        damping=round(2.0 * math.sqrt(stiffness * (inertia + armature)), DIGITS),
        armature=round(armature, DIGITS),
    )


def _moved_links(model: RobotModel, joint: ModelJoint) -> list[str]:
    return [link for link in model.frames if joint in model.ancestors(link)]


def _inertia(model: RobotModel, joint: ModelJoint) -> float:
    """Return the inertia about a joint of the links that it moves, as points with all joints at zero [kg m^2].

    For a joint that slides, it is their mass [kg].
    """
    origin, total = np.array(model.frames[joint.child][0]), 0.0
    for link in _moved_links(model, joint):
        arm = np.cross(joint.axis, np.array(model.centres[link]) - origin)
        total += model.masses[link] * (1.0 if joint.slides else float(arm @ arm))
    return total
