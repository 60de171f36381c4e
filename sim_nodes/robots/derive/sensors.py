"""Sensors derived from a model: from `<sensor>` elements of Gazebo, or links named by convention."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from seoro.deferred import dataclass
from sim_nodes.geometry import rotated, wrap, yaw_of
from sim_nodes.robots.declaration import CameraDeclaration, ImuDeclaration, LidarDeclaration
from sim_nodes.robots.derive.model import RobotModel
from sim_nodes.robots.derive.wheels import BaseFrame
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE

LIDARS = re.compile(r"(^|_)(base_scan|scan|laser|lidar|rplidar|hokuyo|velodyne|sick|lds|ydlidar)(\d*|_|$)", re.I)
IMUS = re.compile(r"(^|_)imu(\d*|_|$)", re.I)
CAMERAS = re.compile(r"(^|_)(camera|realsense|zed|oakd)(\d*|_|$)", re.I)
NOT_A_MOUNT = re.compile(r"optical|depth|infra|mount|bracket|holder|support", re.I)
LEVEL = 0.02  # largest horizontal component of the axis of a lidar
DIGITS = 6  # of derived numbers
MAX_BEAMS = 720  # per turn; more cost time
RANGES = (0.1, 12.0)  # [m] of a lidar without values
IMU = ImuDeclaration(
    rate=50.0, accelerometer_noise=0.02, accelerometer_bias=0.05, gyroscope_noise=0.0005, gyroscope_bias=0.002
)


@dataclass(frozen=True)
class DerivedSensors:
    """Sensors of a robot, and notes on those left out."""

    lidar: LidarDeclaration | None
    imu: ImuDeclaration | None
    cameras: tuple[CameraDeclaration, ...]
    notes: tuple[str, ...]


def derive_sensors(model: RobotModel, base: BaseFrame, source: Any) -> DerivedSensors:
    """Derive the sensors of a robot.

    Args:
        model: Its model.
        base: Frame of its base.
        source: Root element of its file.
    """
    given = {link: sensor for link, sensor in _sensors(source) if link in model.frames}
    notes: list[str] = []
    return DerivedSensors(
        _lidar(model, base, given, notes), _imu(model, given), tuple(_cameras(model, given)), tuple(notes)
    )


def _sensors(source: Any) -> Iterator[tuple[str, Any]]:
    """Yield the link and the element of each <sensor> of a file."""
    for tag, key in (("gazebo", "reference"), ("link", "name")):
        for element in source.iter(tag):
            yield from ((str(element.get(key)), sensor) for sensor in element.findall("sensor"))


def _named(model: RobotModel, pattern: re.Pattern[str]) -> list[str]:
    return [link for link in model.frames if pattern.search(link) and not NOT_A_MOUNT.search(link)]


def _lidar(
    model: RobotModel, base: BaseFrame, given: Mapping[str, Any], notes: list[str]
) -> LidarDeclaration | None:
    known = {link: each for link, each in given.items() if each.get("type", "").endswith(("ray", "lidar"))}
    for link in dict.fromkeys((*known, *_named(model, LIDARS))):
        position, orientation = model.frames[link]
        axis = rotated(orientation, (0.0, 0.0, 1.0))
        if axis[2] < 0.0 or math.hypot(axis[0], axis[1]) > LEVEL:
            notes.append(f"no lidar at link {link!r}, because it is not level")
            continue
        element = known.get(link)
        x, y = base.place(position)
        return LidarDeclaration(
            link=link,
            x=round(x, DIGITS) + 0.0,  # not -0.0
            y=round(y, DIGITS) + 0.0,
            yaw=round(wrap(yaw_of(orientation) - base.yaw), DIGITS),
            beams=_beams(element),
            rate=min(50.0, _number(element, "update_rate", 10.0)),
            min_range=max(0.01, _number(element, ".//range/min", RANGES[0])),
            max_range=min(100.0, _number(element, ".//range/max", RANGES[1])),
            noise=_number(element, ".//noise/stddev", 0.01),
        )
    return None


def _beams(element: Any) -> int:
    """Return the beams per turn: the lidar of a declaration turns, so a sector is completed."""
    ends = [_number(element, f".//scan/horizontal/{end}_angle", math.pi, signed=True) for end in ("min", "max")]
    sector = abs(ends[1] - ends[0]) or 2.0 * math.pi
    samples = _number(element, ".//scan/horizontal/samples", 360.0)
    return min(MAX_BEAMS, max(30, round(samples * 2.0 * math.pi / sector)))


def _imu(model: RobotModel, given: Mapping[str, Any]) -> ImuDeclaration | None:
    known = [each for each in given.values() if each.get("type") == "imu"]
    if known:
        return IMU.model_copy(update={"rate": min(50.0, _number(known[0], "update_rate", IMU.rate))})
    return IMU if _named(model, IMUS) else None


def _cameras(model: RobotModel, given: Mapping[str, Any]) -> Iterator[CameraDeclaration]:
    known = {link: each for link, each in given.items() if "camera" in each.get("type", "")}
    by_name = _named(model, CAMERAS)[:1]  # further ones are mostly frames of the same camera
    for link in known or by_name:
        element = known.get(link)
        width = _within(round(_number(element, ".//image/width", 640.0)), MIN_SIZE, MAX_SIZE)
        height = _within(round(_number(element, ".//image/height", 480.0)), MIN_SIZE, MAX_SIZE)
        horizontal = _number(element, ".//horizontal_fov", 1.2)
        vertical = 2.0 * math.atan(math.tan(min(horizontal, math.pi - 0.1) / 2.0) * height / width)
        yield CameraDeclaration(
            name=re.sub(r"(_link|_frame)$", "", re.sub(r"\W", "_", link)),
            link=link,
            x=0.0,
            y=0.0,
            z=0.0,
            fov=min(max(round(vertical, 4), MIN_FOV), MAX_FOV),
            width=width,
            height=height,
        )


def _within(value: int, low: int, high: int) -> int:
    return min(max(value, low), high)


def _number(element: Any, path: str, usual: float, *, signed: bool = False) -> float:
    """Return a number of an element; the usual one if it is missing or not positive."""
    text = None if element is None else element.findtext(path)
    try:
        value = usual if text is None else float(text)
    except ValueError:
        return usual
    return value if math.isfinite(value) and (signed or value > 0.0) else usual
