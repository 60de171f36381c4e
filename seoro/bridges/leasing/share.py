"""What of all that has happened at a node is whose: each run sees what its own robots do, by its own clock."""

from __future__ import annotations

from typing import TypeVar

from seoro.bridges.leasing.leases import Hold
from seoro.bridges.wire.feedback import NavigationFeedback
from seoro.bridges.wire.happened import Happening, Happenings
from seoro.bridges.wire.passing import Contact, Departure, Occurrence

W = TypeVar("W", Occurrence, Contact, Departure, NavigationFeedback)


def own_id(holder: str, identifier: str) -> str:
    """An id of a goal or a watch that no other client gives: clients of one node share its ids."""
    return f"{holder}.{identifier}"


def share_of(hold: Hold, happenings: Happenings) -> Happenings:
    """What of all that a client is told, up to the same number, with times since it has taken its robots."""
    own = tuple(_told(hold, each) for each in happenings.happenings if _is_own(hold, each))
    return Happenings(number=happenings.number, happenings=own)


def _is_own(hold: Hold, happening: Happening) -> bool:
    if (of_goal := happening.occurrence or happening.caution) is not None:
        return of_goal.id.startswith(own_id(hold.holder.holder, ""))
    if happening.contact is not None:
        return hold.has(happening.contact.first) or hold.has(happening.contact.second)
    if happening.departure is not None:
        return hold.has(happening.departure.robot)
    return happening.feedback is not None and hold.has(happening.feedback.robot)


def _told(hold: Hold, happening: Happening) -> Happening:
    return Happening(
        number=happening.number,
        occurrence=_since(hold, happening.occurrence),
        contact=_since(hold, happening.contact),
        departure=_since(hold, happening.departure),
        feedback=_since(hold, happening.feedback),
        caution=happening.caution,
    )


def _since(hold: Hold, what: W | None) -> W | None:
    return None if what is None else what.model_copy(update={"time": what.time - hold.began})
