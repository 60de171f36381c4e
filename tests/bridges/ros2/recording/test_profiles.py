from itertools import product

import pytest
import yaml

from seoro.bridges.ros2.recording.profiles import profile, read_profiles
from seoro.bridges.ros2.wire import Durability, History, Liveliness, Qos, Reliability

ALL = [
    Qos(*policies, depth=7, deadline=1_500_000_000, liveliness=liveliness, lease=lease)
    for policies in product(Reliability, Durability, History)
    for liveliness, lease in zip(Liveliness, (None, 1), strict=True)
]


def test_written_profiles_are_read_back_as_a_list_or_text() -> None:
    written = [profile(qos) for qos in ALL]
    assert read_profiles(written) == read_profiles(yaml.safe_dump(written)) == tuple(ALL)
    assert read_profiles("") == ()


def test_unsupported_qos_values_are_read_as_the_default() -> None:
    unknown = {
        "history": "unknown",
        "reliability": "system_default",
        "durability": 0,
        "liveliness": 9,
        "depth": -1,
    }
    assert read_profiles([unknown]) == (Qos(),)


@pytest.mark.parametrize("written", ["- [", "reliable", "{}\n- a", ["reliable"]])
def test_invalid_lists_of_profiles_are_refused(written: str | list[str]) -> None:
    with pytest.raises(ValueError, match=r"invalid (YAML of )?QoS"):
        read_profiles(written)
