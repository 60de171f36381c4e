"""Verbs of each capability, all of which a node must serve to have it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from seoro.bridges import wire
from seoro.runtime.contracts.robots import Arms, DrivenRobots, LocalisedRobots, MobileRobots
from seoro.runtime.contracts.sensors import Cameras, Faults, Sensors
from seoro.runtime.contracts.worlds import Simulation, Snapshots, Worlds

_VERBS: Mapping[type, tuple[wire.Verb[Any, Any], ...]] = {
    MobileRobots: (
        wire.SET_INITIAL_POSE,
        wire.NAVIGATE_THROUGH_POSES,
        wire.WATCH_PROXIMITY,
        wire.WATCH_DISTANCE,
        wire.CANCEL_GOAL,
        wire.CANCEL_WATCH,
    ),
    LocalisedRobots: (
        wire.REINITIALIZE_GLOBAL_LOCALIZATION,
        wire.WATCH_LOCALIZATION,
        wire.GET_LOCALIZATION,
        wire.CANCEL_WATCH,
    ),
    DrivenRobots: (wire.DRIVE, wire.CMD_VEL, wire.CANCEL_GOAL),
    Arms: (
        wire.FOLLOW_JOINT_TRAJECTORY,
        wire.MOVE_TO_POSE,
        wire.GRIPPER_COMMAND,
        wire.HOLD_ENTITY,
        wire.WATCH_JOINT,
        wire.GET_ARM_STATE,
        wire.CANCEL_GOAL,
        wire.CANCEL_WATCH,
    ),
    Simulation: (
        wire.SPAWN_ENTITY,
        wire.SPAWN_ENTITIES,
        wire.GET_RELATIVE_POSE,
        wire.DELETE_ENTITY,
        wire.GET_ENTITIES,
        wire.SET_ENTITY_STATE,
        wire.STEP_SIMULATION,
        wire.RESET_SIMULATION,
    ),
    Worlds: (wire.CHANGE_WORLD,),
    Cameras: (
        wire.SPAWN_CAMERA,
        wire.GET_CAMERAS,
        wire.AIM_CAMERA,
        wire.FOLLOW_ENTITY,
        wire.SET_ENTITY_STATE,
        wire.DELETE_ENTITY,
        wire.GET_CAMERA_IMAGE,
    ),
    Sensors: (wire.WATCH_SENSOR, wire.WATCH_BUMPER, wire.WATCH_RANGE, wire.CHECK_RATE, wire.CANCEL_WATCH),
    Faults: (wire.INJECT_FAULT, wire.CLEAR_FAULTS, wire.CANCEL_GOAL),
    Snapshots: (wire.SAVE_STATE, wire.RESTORE_STATE),
}


def missing_verbs(contract: type, features: Collection[str]) -> tuple[str, ...]:
    """Names of the verbs of a contract that are not among the features of a node."""
    return tuple(verb.name for verb in _VERBS.get(contract, ()) if verb.name not in features)
