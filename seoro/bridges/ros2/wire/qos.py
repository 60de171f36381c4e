"""Quality of service: policies that publishers offer and subscriptions request."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType


class Reliability(Enum):
    """Retransmission of lost messages."""

    RELIABLE = "reliable"
    BEST_EFFORT = "best_effort"


class Durability(Enum):
    """Delivery of earlier messages to late subscriptions."""

    VOLATILE = "volatile"
    TRANSIENT_LOCAL = "transient_local"


class History(Enum):
    """Messages kept for a subscription: the last ones, or all."""

    KEEP_LAST = "keep_last"
    KEEP_ALL = "keep_all"


class Liveliness(Enum):
    """Way in which a publisher signals that it is alive."""

    AUTOMATIC = "automatic"
    MANUAL_BY_TOPIC = "manual_by_topic"


@dataclass(frozen=True)
class Qos:
    """QoS profile.

    Attributes:
        depth: Number of kept messages, with the history policy "keep last".
        deadline: Maximum interval between messages [ns]; None for no limit.
        lifespan: Time after which a message expires [ns]; None for never.
        lease: Time without a liveliness signal after which a publisher counts as lost [ns]; None for never.
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
            raise ValueError(f"invalid history depth {self.depth}: expected at least 1")
        for name, value in (("deadline", self.deadline), ("lifespan", self.lifespan), ("lease", self.lease)):
            if value is not None and not 0 < value < INFINITE:
                raise ValueError(f"invalid {name} {value}: expected a positive number of nanoseconds, or None")

    @property
    def is_reliable(self) -> bool:
        """Whether lost messages are sent again."""
        return self.reliability is Reliability.RELIABLE

    @property
    def is_transient_local(self) -> bool:
        """Whether late subscriptions get earlier messages."""
        return self.durability is Durability.TRANSIENT_LOCAL


LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)  # late subscriptions get the last message
INFINITE = (1 << 63) - 1  # [ns]; infinite duration of rmw


def matching_qos(offered: Sequence[Qos]) -> Qos:
    """Return a QoS profile to request that all publishers offer: reliable or transient local only if all are."""
    return Qos(
        Reliability.RELIABLE if all(qos.is_reliable for qos in offered) else Reliability.BEST_EFFORT,
        Durability.TRANSIENT_LOCAL
        if offered and all(qos.is_transient_local for qos in offered)
        else Durability.VOLATILE,
        depth=max((qos.depth for qos in offered), default=100),
    )


def mismatch(offered: Qos, requested: Qos) -> str:
    """Describe how an offered profile fails a requested one; empty if it does not."""
    if requested.is_reliable and not offered.is_reliable:
        return "best_effort is offered, reliable is requested"
    if requested.is_transient_local and not offered.is_transient_local:
        return "volatile is offered, transient_local is requested"
    return ""


# Presets of ROS 2 (rmw/qos_profiles.h), and two more for scenarios. Policies that ROS 2 leaves to the middleware
# ("system default") have the values of rmw_zenoh.
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
