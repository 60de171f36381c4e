"""Result codes and refusals of requests."""

from __future__ import annotations

from enum import IntEnum

from seoro.bridges.wire.message import Message


class Result(IntEnum):
    """Result codes of `simulation_interfaces`; codes above 100 belong to one service each."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4


class SpawnResult(IntEnum):
    """Result codes of `spawn_entity` beyond the common ones."""

    NAME_NOT_UNIQUE = 101
    NAME_INVALID = 102
    UNSUPPORTED_FORMAT = 103
    NO_RESOURCE = 104
    NAMESPACE_INVALID = 105
    RESOURCE_PARSE_ERROR = 106
    MISSING_ASSETS = 107
    UNSUPPORTED_ASSETS = 108
    INVALID_POSE = 109


class StateResult(IntEnum):
    """Result codes of `set_simulation_state` beyond the common ones."""

    ALREADY_IN_TARGET_STATE = 101
    STATE_TRANSITION_ERROR = 102
    INCORRECT_TRANSITION = 103


class WorldResult(IntEnum):
    """Result codes of `load_world` and `unload_world` beyond the common ones."""

    UNSUPPORTED_FORMAT = 101
    NO_RESOURCE = 102
    RESOURCE_PARSE_ERROR = 103
    NO_WORLD_LOADED = 110


class Refusal(Message):
    """Reason why a request was refused: a result code and a message."""

    code: int
    message: str


class LabResult(IntEnum):
    """Result codes about holds of robots, beyond the common ones."""

    HELD = 201  # another client holds them, or is first in the wait queue
    STOPPED = 202  # by an emergency stop
    NOT_HELD = 203  # the client does not hold them, or lost its hold
    UNAVAILABLE = 204  # the node is busy or ends: a later attempt may succeed
    FAULT = 205  # internal error: the code of the node raised an exception
