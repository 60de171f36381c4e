"""Quality of service: what publishers offer and subscriptions ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType


class Reliability(Enum):
    """Whether what is lost on its way is sent again."""

    RELIABLE = "reliable"
    BEST_EFFORT = "best_effort"


class Durability(Enum):
    """Whether subscriptions that come later get what was published before."""

    VOLATILE = "volatile"
    TRANSIENT_LOCAL = "transient_local"


class History(Enum):
    """How many messages wait for a reader: the last ones, or all."""

    KEEP_LAST = "keep_last"
    KEEP_ALL = "keep_all"


class Liveliness(Enum):
    """How a publisher shows that it is alive."""

    AUTOMATIC = "automatic"
    MANUAL_BY_TOPIC = "manual_by_topic"


@dataclass(frozen=True)
class Qos:
    """A profile of quality of service.

    Attributes:
        depth: How many messages are kept; of no meaning where all are.
        deadline: [ns] between messages at most; none when None.
        lifespan: [ns] after which a message is worth nothing; never when None.
        lease: [ns] without a sign of life after which a publisher counts as gone; never when None.
    """

    reliability: Reliability = Reliability.RELIABLE
    durability: Durability = Durability.VOLATILE
    history: History = History.KEEP_LAST
    depth: int = 10
    deadline: int | None = None
    lifespan: int | None = None
    liveliness: Liveliness = Liveliness.AUTOMATIC
    lease: int | None = None

    def __post_init__(self) -> None:
        if not 0 < self.depth < 1 << 31:
            raise ValueError(f"the depth of a history is at least 1, not {self.depth}")
        for name, value in (("deadline", self.deadline), ("lifespan", self.lifespan), ("lease", self.lease)):
            if value is not None and not 0 < value < INFINITE:
                raise ValueError(f"the {name} is a positive number of nanoseconds, or None for none; not {value}")

    @property
    def is_reliable(self) -> bool:
        """Whether what is lost is sent again."""
        return self.reliability is Reliability.RELIABLE

    @property
    def is_transient_local(self) -> bool:
        """Whether late subscriptions get what was published before."""
        return self.durability is Durability.TRANSIENT_LOCAL


INFINITE = (1 << 63) - 1  # [ns], rmw's number for a duration without end

# What ROS 2 calls its presets (rmw/qos_profiles.h), and two that scenarios have beside them. What ROS 2 leaves to
# the middleware ("system default") is what rmw_zenoh chooses.
PRESETS: Mapping[str, Qos] = MappingProxyType(
    {
        "parameters": Qos(depth=1000),
        "parameter_events": Qos(depth=1000),
        "sensor_data": Qos(reliability=Reliability.BEST_EFFORT, depth=5),
        "services_default": Qos(depth=10),
        "system_default": Qos(depth=42),
        "system_default_reliable": Qos(depth=42),
        "system_default_transient_local": Qos(durability=Durability.TRANSIENT_LOCAL, depth=42),
    }
)
