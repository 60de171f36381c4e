"""Ways of people to avoid others, shared by contracts and messages."""

from __future__ import annotations

from enum import StrEnum


class Avoidance(StrEnum):
    """Ways of people to avoid each other and robots."""

    NONE = "none"
    SOCIAL_FORCE = "social_force"
    ORCA = "orca"
