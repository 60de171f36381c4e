"""Some ROS 2 messages as types of Cyclone DDS, an independent implementation of CDR."""

# mypy: disable-error-code="type-arg, valid-type, misc"
# Its sequences and arrays take their elements when they are called, which mypy does not see.

from dataclasses import asdict, dataclass, fields
from typing import Any, get_args, get_type_hints

from cyclonedds.idl import IdlStruct
from cyclonedds.idl._support import Endianness
from cyclonedds.idl.types import array, float32, float64, int8, int32, sequence, uint8, uint32, uint64


@dataclass
class Time(IdlStruct):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct):
    stamp: Time
    frame_id: str


@dataclass
class Vector3(IdlStruct):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Twist(IdlStruct):
    linear: Vector3
    angular: Vector3


@dataclass
class LaserScan(IdlStruct):
    header: Header
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]


@dataclass
class JointState(IdlStruct):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


@dataclass
class CompressedImage(IdlStruct):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class UUID(IdlStruct):
    uuid: array[uint8, 16]


@dataclass
class GoalInfo(IdlStruct):
    goal_id: UUID
    stamp: Time


@dataclass
class GoalStatus(IdlStruct):
    goal_info: GoalInfo
    status: int8


@dataclass
class GoalStatusArray(IdlStruct):
    status_list: sequence[GoalStatus]


@dataclass
class Transform(IdlStruct):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct):
    transforms: sequence[TransformStamped]


@dataclass
class KeyValue(IdlStruct):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class MultiArrayDimension(IdlStruct):
    label: str
    size: uint32
    stride: uint32


@dataclass
class MultiArrayLayout(IdlStruct):
    dim: sequence[MultiArrayDimension]
    data_offset: uint32


@dataclass
class UInt64MultiArray(IdlStruct):
    layout: MultiArrayLayout
    data: sequence[uint64]


def encode(name: str, value: dict[str, Any], *, big_endian: bool = False) -> bytes:
    """Encode a value as CDR by Cyclone DDS."""
    order = Endianness.Big if big_endian else Endianness.Little
    payload: bytes = _made(_type(name), value).serialize(endianness=order, use_version_2=False)
    return payload


def decode(name: str, payload: bytes) -> dict[str, Any]:
    """Decode a payload by Cyclone DDS."""
    value: dict[str, Any] = _plain(asdict(_type(name).deserialize(payload)))
    return value


def _type(name: str) -> Any:
    return globals()[name.rpartition("/")[2]]


def _made(kind: Any, value: Any) -> Any:
    if isinstance(value, dict):
        hints = get_type_hints(kind)
        return kind(**{field.name: _made(hints[field.name], value[field.name]) for field in fields(kind)})
    if isinstance(value, list) and value and isinstance(value[0], dict):
        (element,) = get_args(kind)
        return [_made(element, item) for item in value]
    return value


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple | bytes) else value
