"""An emergency stop on its way to the guard of a bridge, whatever the event loop of the bridge does meanwhile."""

from __future__ import annotations

from collections.abc import Callable


class Alarm:
    """Whether an emergency stop was given that the bridge has not carried out yet; for any thread.

    Attributes:
        is_on: Whether there is one.
        when_changed: Called when that has changed.
    """

    def __init__(self) -> None:
        self.is_on = False
        self.when_changed: Callable[[], None] = lambda: None

    def set(self, is_on: bool) -> None:
        """Note that there is an emergency stop, or that the bridge has carried it out."""
        self.is_on = is_on
        self.when_changed()
