"""Measures of robots and other entities; see `Measuring`."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.bridges.wire.refusal import name_list
from seoro.errors import BackendRefused
from seoro.robotics.measures import MeasureLimit
from seoro.runtime.contracts.backends import Reporter


class MeasureRequests(Requests):
    """The capability `Measuring` of a node."""

    async def watch_measure(self, entity: str, limit: MeasureLimit, report: Reporter) -> str:
        """See `Measuring`."""
        request = wire.WatchMeasure(id=self.new_id("watch"), entity=entity, limit=limit)
        return await self.start(wire.WATCH_MEASURE, request, report)

    async def end_measure_watch(self, watch: str) -> float | None:
        """See `Measuring`."""
        ended = await self.cancel_report(wire.CANCEL_WATCH, wire.CancelWatch(id=watch), watch)
        return None if ended is None else ended.margin

    async def measurement(self, entity: str, name: str) -> float | None:
        """See `Measuring`."""
        measured = await self.ask(wire.GET_MEASUREMENTS, wire.Empty())
        found = measured.robots.get(entity) or measured.entities.get(entity)
        if found is None:
            known = name_list([*measured.robots, *measured.entities])
            raise BackendRefused(
                f"no measurements of '{entity}'; expected a robot or a movable entity: {known}",
                wire.Result.NOT_FOUND,
            )
        values = {
            key: value
            for key, value in found.model_dump().items()
            if value is None or isinstance(value, int | float)
        }
        if name not in values:
            raise BackendRefused(
                f"unknown measurement '{name}' of '{entity}'; expected one of {name_list(values)}",
                wire.Result.NOT_FOUND,
            )
        return values[name]
