"""Quality of service."""

import pytest

from seoro.bridges.ros2.wire import PRESETS, Durability, Qos, Reliability
from seoro.bridges.ros2.wire.qos import never_meet

LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL)
SENSOR = PRESETS["sensor_data"]


def test_publishers_have_to_offer_what_subscriptions_ask_for() -> None:
    assert never_meet(Qos(), SENSOR) is None
    assert never_meet(LATCHED, Qos()) is None
    assert "best effort" in (never_meet(SENSOR, Qos()) or "")
    assert "volatile" in (never_meet(Qos(), LATCHED) or "")


def test_presets_are_those_of_ros_2() -> None:
    assert Qos(Reliability.BEST_EFFORT, depth=5) == SENSOR
    assert PRESETS["system_default_transient_local"].is_transient_local


@pytest.mark.parametrize("wrong", [{"depth": 0}, {"deadline": 0}, {"lifespan": -1}, {"lease": 1 << 63}])
def test_what_makes_no_sense_is_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"depth|nanoseconds"):
        Qos(**wrong)  # type: ignore[arg-type]
