"""Where robots believe to be, and robots that do not know it."""

from __future__ import annotations

from seoro.bridges.wire.geometry import Pose
from seoro.bridges.wire.message import Empty, Message, Verb


class LocalisedRobot(Message):
    """A robot by name."""

    robot: str


class WatchLocalization(Message):
    """Report when the localisation of a robot has a pose; at once if it has one already."""

    id: str
    robot: str


class Localization(Message):
    """What the localisation of a robot says, and how far that is from the truth.

    Attributes:
        pose: Where it believes the robot to be; None when it does not know.
        covariance: Of x, y and yaw, row by row [m^2, m rad, rad^2]; None without a pose.
        particles: How many it works with.
        error: Distance between this pose and the true one [m], which the robot does not know; None without a pose.
    """

    pose: Pose | None
    covariance: tuple[float, ...] | None
    particles: int
    error: float | None


REINITIALIZE_GLOBAL_LOCALIZATION = Verb("reinitialize_global_localization", LocalisedRobot, Empty)
WATCH_LOCALIZATION = Verb("watch_localization", WatchLocalization, Empty)
GET_LOCALIZATION = Verb("get_localization", LocalisedRobot, Localization)
