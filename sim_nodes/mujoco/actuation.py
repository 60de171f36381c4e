"""Limits of the motors of compiled models of MuJoCo, by joint."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import mujoco

TRANSMISSION, GAIN, BIAS = mujoco.mjtTrn, mujoco.mjtGain, mujoco.mjtBias
OF_JOINTS = (int(TRANSMISSION.mjTRN_JOINT), int(TRANSMISSION.mjTRN_JOINTINPARENT))


def efforts_of(model: Any) -> dict[int, float]:
    """Return the effort limits of joints with motors [N m], [N]; infinite ones if the file has none.

    The limit is that of the joint (`actuatorfrcrange`), or the sum over its actuators. An actuator is limited by
    its `forcerange`, or by its `ctrlrange` if it is a motor of torque. Actuators of fixed tendons act on all
    joints of the tendon.
    """
    sums: dict[int, float] = defaultdict(float)
    for actuator in range(model.nu):
        force = _force(model, actuator)
        for joint, arm in _arms(model, actuator):
            sums[joint] += force * abs(arm)
    return {joint: min(effort, _joint_limit(model, joint)) for joint, effort in sums.items()}


def _joint_limit(model: Any, joint: int) -> float:
    """Return the limit of the efforts of all actuators at a joint."""
    return float(abs(model.jnt_actfrcrange[joint]).max()) if model.jnt_actfrclimited[joint] else math.inf


def _force(model: Any, actuator: int) -> float:
    """Return the greatest force of an actuator, before its gear."""
    if model.actuator_forcelimited[actuator]:
        return float(abs(model.actuator_forcerange[actuator]).max())
    is_motor = (
        model.actuator_gaintype[actuator] == GAIN.mjGAIN_FIXED
        and model.actuator_biastype[actuator] == BIAS.mjBIAS_NONE
    )
    if is_motor and model.actuator_ctrllimited[actuator]:
        gain = float(model.actuator_gainprm[actuator, 0])
        return abs(gain) * float(abs(model.actuator_ctrlrange[actuator]).max())
    return math.inf


def _arms(model: Any, actuator: int) -> Iterator[tuple[int, float]]:
    """Yield the joints that an actuator moves, with the ratio of their effort to its force."""
    gear, target = float(model.actuator_gear[actuator, 0]), int(model.actuator_trnid[actuator, 0])
    if model.actuator_trntype[actuator] in OF_JOINTS:
        yield target, gear
    elif model.actuator_trntype[actuator] == TRANSMISSION.mjTRN_TENDON:
        yield from ((joint, gear * factor) for joint, factor in joints_of_tendon(model, target))


def joints_of_tendon(model: Any, tendon: int) -> Iterator[tuple[int, float]]:
    """Yield the joints of a fixed tendon with their coefficients; none of a spatial one."""
    start = int(model.tendon_adr[tendon])
    for wrap in range(start, start + int(model.tendon_num[tendon])):
        if model.wrap_type[wrap] == mujoco.mjtWrap.mjWRAP_JOINT:
            yield int(model.wrap_objid[wrap]), float(model.wrap_prm[wrap])
