"""Quality of service."""

import pytest

from seoro.bridges.ros2.wire import PRESETS, Qos, Reliability

SENSOR = PRESETS["sensor_data"]


def test_presets_equal_those_of_ros_2() -> None:
    assert Qos(Reliability.BEST_EFFORT, depth=5) == SENSOR
    assert PRESETS["system_default_transient_local"].is_transient_local


@pytest.mark.parametrize("wrong", [{"depth": 0}, {"deadline": 0}, {"lifespan": -1}, {"lease": 1 << 63}])
def test_invalid_settings_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"depth|nanoseconds"):
        Qos(**wrong)  # type: ignore[arg-type]
