"""What sensors say, as it is said on the wire."""

from __future__ import annotations

from collections.abc import Callable

from seoro.bridges import wire
from sim_nodes.messages import flat_pose
from sim_nodes.sensors.bumper import Bumps
from sim_nodes.sensors.imu import Inertial
from sim_nodes.sensors.lidar import Scan
from sim_nodes.sensors.odometry import Odometer
from sim_nodes.sensors.sensor import Sample


def sample_message(sample: Sample[object], time_of_tick: Callable[[int], float]) -> wire.SensorSample:
    """A sample as it is said.

    Args:
        sample: The sample.
        time_of_tick: The time of a tick [s].
    """
    time = time_of_tick(sample.tick)
    match sample.data:
        case Scan(ranges=ranges, angles=angles):
            scan = wire.LaserScan(ranges=tuple(ranges.tolist()), bearings=tuple(angles.tolist()))
            return wire.SensorSample(time=time, lidar=scan)
        case Odometer(pose=pose, travelled=travelled, velocity=velocity):
            odometry = wire.OdometrySample(
                pose=flat_pose(pose), travelled=travelled, linear=velocity.linear, angular=velocity.angular
            )
            return wire.SensorSample(time=time, odometry=odometry)
        case Inertial(acceleration=acceleration, angular_rate=rate):
            imu = wire.ImuSample(
                acceleration=_vector(*acceleration.tolist()), angular_rate=_vector(*rate.tolist())
            )
            return wire.SensorSample(time=time, imu=imu)
        case Bumps(bumps=bumps):
            told = (
                wire.Bump(zone=bump.zone, entity=bump.entity, since=time_of_tick(bump.since)) for bump in bumps
            )
            return wire.SensorSample(time=time, bumper=wire.BumperSample(bumps=tuple(told)))
        case _:
            raise AssertionError(f"there is no message for {type(sample.data).__name__}")


def _vector(x: float, y: float, z: float) -> wire.Vector3:
    return wire.Vector3(x=x, y=y, z=z)
