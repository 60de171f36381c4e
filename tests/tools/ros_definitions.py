"""Definitions of ROS 2 distributions, including those of which seoro has editions of packages only."""

from __future__ import annotations

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.packages import bundled_packages, editions

COMPLETE = ("humble", "jazzy")


def definitions(distribution: str) -> TypeStore:
    """Return the definitions of a distribution: of `nav2_msgs` for Kilted and Lyrical, else those of Jazzy."""
    if distribution in COMPLETE:
        return TypeStore.bundled(distribution)
    edition = next(each for each in editions("nav2_msgs") if f"-{distribution}." in each["nav2_msgs"].origin)
    return TypeStore({**bundled_packages("jazzy"), **edition})
