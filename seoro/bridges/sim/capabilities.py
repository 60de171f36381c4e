"""Verbs of nodes that the contracts of backends require."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from seoro.bridges import wire
from seoro.runtime.contracts.buildings import Doors, Lifts
from seoro.runtime.contracts.measures import Measuring
from seoro.runtime.contracts.people import People
from seoro.runtime.contracts.robots import (
    Arms,
    DrivenRobots,
    LocalisedRobots,
    MobileRobots,
    PathRobots,
    Postures,
    VelocityCommands,
)
from seoro.runtime.contracts.sensors import Cameras, Faults, ForceSensing, Sensors, SightSensing
from seoro.runtime.contracts.tracks import Tracks
from seoro.runtime.contracts.worlds import Frames, NamedPoses, Simulation, Snapshots, Worlds

CAPABILITIES: Mapping[type, tuple[wire.Verb[Any, Any], ...]] = {
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
    DrivenRobots: (wire.DRIVE, wire.CANCEL_GOAL),
    PathRobots: (wire.FOLLOW_PATH, wire.CANCEL_GOAL),
    VelocityCommands: (wire.CMD_VEL,),
    Frames: (wire.GET_RELATIVE_POSE,),
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
    Postures: (wire.TAKE_POSTURE, wire.CANCEL_GOAL),
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
    NamedPoses: (wire.GET_NAMED_POSES,),
    People: (
        wire.SPAWN_PERSON,
        wire.WALK_ALONG,
        wire.WANDER,
        wire.WALK_AFTER,
        wire.STAND_STILL,
        wire.CANCEL_GOAL,
    ),
    Doors: (wire.MOVE_DOOR, wire.LOCK_DOOR, wire.WATCH_DOOR, wire.CANCEL_GOAL, wire.CANCEL_WATCH),
    Lifts: (wire.MOVE_LIFT, wire.WATCH_LIFT, wire.CANCEL_GOAL, wire.CANCEL_WATCH),
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
    ForceSensing: (wire.WATCH_FORCE, wire.CANCEL_WATCH),
    SightSensing: (wire.WATCH_SIGHT, wire.CANCEL_WATCH),
    Faults: (wire.INJECT_FAULT, wire.CLEAR_FAULTS, wire.CANCEL_GOAL),
    Measuring: (wire.WATCH_MEASURE, wire.CANCEL_WATCH, wire.GET_MEASUREMENTS),
    Snapshots: (wire.SAVE_STATE, wire.RESTORE_STATE),
    Tracks: (wire.START_TRACKS, wire.GET_SCENE),
}
"""Verbs of each capability, all of which a node must serve to have it."""
COMMON = frozenset({wire.CANCEL_GOAL, wire.CANCEL_WATCH})  # served by every node with goals or watches


def reason_unserved(contract: type, served: Collection[str], name: str) -> str:
    """Return why a contract is missing; empty if any of its own verbs is served, or if it has none.

    Args:
        contract: The contract.
        served: Names of the served verbs.
        name: Name of the node or robot that serves them, for the reason.
    """
    own = [verb.name for verb in CAPABILITIES.get(contract, ()) if verb not in COMMON]
    if not own or not {*own}.isdisjoint(served):
        return ""
    return f"{name} does not serve {' or '.join(f'`{verb}`' for verb in own)}"
