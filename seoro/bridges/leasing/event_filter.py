"""Selection of the events for a run: those of its robots, with times since its acquisition."""

from __future__ import annotations

from seoro.bridges.leasing.leases import Hold
from seoro.bridges.wire.event_log import LoggedEvent, LoggedEvents


def scoped_id(holder: str, identifier: str) -> str:
    """Return an id of a goal or a watch that is unique among all clients of a node."""
    return f"{holder}.{identifier}"


def events_for(hold: Hold, events: LoggedEvents) -> LoggedEvents:
    """Return the events for a client, with times since it acquired its robots."""
    own = tuple(_shifted(hold, event) for event in events.events if _is_own(hold, event))
    return LoggedEvents(number=events.number, events=own)


def _is_own(hold: Hold, event: LoggedEvent) -> bool:
    if (about_goal := event.occurrence or event.warning) is not None:
        return about_goal.id.startswith(scoped_id(hold.holder.holder, ""))
    if event.contact is not None:
        return hold.holds(event.contact.first) or hold.holds(event.contact.second)
    if event.departure is not None:
        return hold.holds(event.departure.robot)
    return event.feedback is not None and hold.holds(event.feedback.robot)


def _shifted(hold: Hold, event: LoggedEvent) -> LoggedEvent:
    parts = {name: getattr(event, name) for name in ("occurrence", "contact", "departure", "feedback")}
    shifted = {
        name: part.model_copy(update={"time": part.time - hold.began})
        for name, part in parts.items()
        if part is not None
    }
    return event.model_copy(update=shifted)
