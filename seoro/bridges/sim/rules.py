"""Rules for the answers of a simulator node; a violation ends the run as an error."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from seoro.bridges import wire
from seoro.errors import BackendLost
from seoro.robotics.geometry import Pose3D

LONGEST_STEP = 1.0  # [s]
STALLED = 1000  # consecutive grants of less than half a step, after which the clock counts as stalled


class ProtocolViolation(BackendLost):
    """A node violated the protocol; the message has the node, its answer, and the expected one."""


class TimeRules:
    """Rules for the clock of a node, and for the events in its answers to grants.

    Args:
        node: Name of the node in messages.
        features: Features of the node when its world was loaded.
        is_given: Whether this run has assigned an id to a goal or a watch.

    Raises:
        ProtocolViolation: The step or the time of the node is invalid.
    """

    def __init__(self, node: str, features: wire.SimulatorFeatures, is_given: Callable[[str], bool]) -> None:
        self._node = node
        self._step = features.step
        self._is_given = is_given
        self._still = 0  # consecutive grants of less than half a step
        if not (math.isfinite(self._step) and 0.0 < self._step <= LONGEST_STEP):
            self._broken(f"a step of {self._step} s", f"a step above 0 s, and at most {LONGEST_STEP:g} s")
        if not (math.isfinite(features.time) and features.time >= 0.0):
            self._broken(f"a time of {features.time} s when its world was loaded", "a finite time from 0 s on")

    def check(self, before: float, granted: float, advanced: wire.Advanced) -> None:
        """Check the answer to a grant.

        Args:
            before: The time of the run before it [s].
            granted: End of the granted time [s].
            advanced: The answer.

        Raises:
            ProtocolViolation: The answer violates a rule.
        """
        time, latest = advanced.time, max(before, granted) + self._step
        grant = f"the answer to a grant from {before:.9g} s to {granted:.9g} s"
        if not math.isfinite(time):
            self._broken(f"a time of {time} s in {grant}", "a finite time")
        if time < before:
            self._broken(f"a time of {time:.9g} s in {grant}", "a clock that never goes back")
        if time > latest:
            self._broken(f"a time of {time:.9g} s in {grant}", "a time within the grant, or a step beyond")
        self._still = self._still + 1 if before < granted and time - before < self._step / 2 else 0
        if self._still >= STALLED:
            found = f"times that differ by less than half a step in {STALLED} grants, the last {time:.9g} s"
            self._broken(found, "a clock that advances")
        for what, when in _occurrences(advanced):
            if not before - self._step <= when <= time + self._step:
                self._broken(
                    f"{what} of {when:.9g} s in an answer from {before:.9g} s to {time:.9g} s",
                    "occurrences within the simulated time",
                )
        for occurrence in advanced.occurrences:
            if not self._is_given(occurrence.id):
                self._broken(f"the end of a goal or a watch '{occurrence.id:.100}'", "ids of this run")

    def _broken(self, found: str, expected: str) -> None:
        raise _violation(self._node, found, expected)


def _violation(node: str, found: str, expected: str) -> ProtocolViolation:
    return ProtocolViolation(f"{node} violated the protocol: it sent {found}; expected {expected}")


def _occurrences(advanced: wire.Advanced) -> Iterable[tuple[str, float]]:
    """Yield the occurrences of an answer as text, each with its time [s]."""
    yield from ((f"the end of '{each.id:.100}'", each.time) for each in advanced.occurrences)
    yield from ((f"a contact of '{each.first:.100}'", each.time) for each in advanced.contacts)
    yield from ((f"the departure of '{each.robot:.100}'", each.time) for each in advanced.departures)
    yield from ((f"feedback of '{each.robot:.100}'", each.time) for each in advanced.feedback)


def check_pose(node: str, what: str, pose: Pose3D) -> None:
    """Check a pose that a node has sent.

    Args:
        node: Name of the node in messages.
        what: Name of the pose.
        pose: The pose.

    Raises:
        ProtocolViolation: A number is not finite.
    """
    place, turned = pose.position, pose.orientation
    values = (place.x, place.y, place.z, turned.roll, turned.pitch, turned.yaw)
    if not all(map(math.isfinite, values)):
        shown = ", ".join(f"{value:g}" for value in values)
        raise _violation(node, f"{what} as ({shown})", "finite numbers")


def check_deviation(node: str, what: str, deviation: float) -> None:
    """Check a distance from a true pose that a node has sent. NaN would pass all comparisons with limits.

    Args:
        node: Name of the node in messages.
        what: Name of the distance.
        deviation: The distance [m].

    Raises:
        ProtocolViolation: The distance is not finite, or negative.
    """
    if not (math.isfinite(deviation) and deviation >= 0.0):
        raise _violation(node, f"{what} as {deviation:g} m", "a finite number from 0 on")
