"""Contract of backends that report contacts of robots."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from seoro.lang.frozen import Value


class Contact(Value):
    """A contact of two entities, as reported by a backend.

    Args:
        first: Name of one entity.
        second: Name of the other entity.
        time: Time on the backend's clock [s].
        strikers: Entities that moved into the other; None if unknown.
        position: Point of contact [m]; None if unknown.
        held: Robots by the entity of the contact that they hold.
    """

    first: str
    second: str
    time: float
    strikers: tuple[str, ...] | None = None
    position: tuple[float, ...] | None = None
    held: Mapping[str, str] = {}

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> Contact:
        """Create a contact from the arguments of a `CONTACT` event."""
        strikers, position = arguments.get("strikers"), arguments.get("position")
        return cls(
            arguments["first"],
            arguments["second"],
            arguments["time"],
            None if strikers is None else tuple(strikers),
            None if position is None else tuple(position),
            arguments.get("held") or {},
        )

    def sides(self, robot: str) -> tuple[str, str | None]:
        """Return the robot's side of the contact (itself or a held entity), and the other; None if uninvolved."""
        for mine, other in ((self.first, self.second), (self.second, self.first)):
            if mine == robot:
                return mine, other
        for mine, other in ((self.first, self.second), (self.second, self.first)):
            if self.held.get(mine) == robot:
                return mine, other
        return "", None

    def is_struck_by(self, robot: str) -> bool:
        """Whether the robot moved into the other entity; True if unknown."""
        return self.strikers is None or robot in self.strikers


@runtime_checkable
class ContactSensing(Protocol):
    """Robots whose contacts are reported as `contact` events."""

    def senses_contacts(self, robot: str) -> bool:
        """Whether all contacts of a robot are reported, including the striker."""
