"""Watches of measures of robots and other entities."""

from __future__ import annotations

from seoro.bridges.wire.message import Empty, TrackedRequest, Verb
from seoro.robotics.measures import MeasureLimit


class WatchMeasure(TrackedRequest):
    """Report when a measure of an entity reaches a limit, with the value, place and time in the message.

    Limits are checked in every tick of 20 ms. Clearances and errors of the localisation are of robots that drive,
    and work is of robots.
    """

    entity: str
    limit: MeasureLimit


WATCH_MEASURE = Verb("watch_measure", WatchMeasure, Empty)
