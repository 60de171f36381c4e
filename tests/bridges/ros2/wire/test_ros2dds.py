"""Dialect of the bridge for DDS: tokens of its sources, and tokens that it must parse."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges.ros2.wire import Durability, Endpoint, History, Kind, Node, Qos, Reliability, Ros2Dds
from tests.bridges.ros2.wire.systems import endpoints, without_times

BRIDGE = "3b1a"
STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
DIALECT = Ros2Dds()


def test_keys_equal_names() -> None:
    assert DIALECT.key("/bot1/cmd_vel", "geometry_msgs/msg/Twist", None) == "bot1/cmd_vel"
    assert DIALECT.key_expression("/bot1/cmd_vel", "geometry_msgs/msg/Twist") == "bot1/cmd_vel"
    assert DIALECT.type_hash("bot1/cmd_vel") is None


def test_tokens_equal_those_of_the_bridge() -> None:
    qos = Qos(Reliability.RELIABLE, Durability.TRANSIENT_LOCAL, depth=3)
    latched = Endpoint(Kind.PUBLISHER, "/bot1/chatter", STRING, BRIDGE, STRING_HASH, qos)
    assert DIALECT.token(latched) == (
        f"@/{BRIDGE}/@ros2_lv/MP/bot1§chatter/std_msgs§msg§String/:1:1:0,3:typehash={STRING_HASH};"
    )
    server = Endpoint(Kind.SERVER, "/reset", "std_srvs/srv/Empty", BRIDGE)
    assert DIALECT.token(server) == f"@/{BRIDGE}/@ros2_lv/SS/reset/std_srvs§srv§Empty"
    assert DIALECT.token(Node(BRIDGE, 0, "talker")) is None


@given(endpoints())
def test_announcements_are_read(endpoint: Endpoint) -> None:
    token = DIALECT.token(endpoint)
    assert token is not None
    reported = replace(endpoint, node=None, number=None)
    if endpoint.kind in {Kind.PUBLISHER, Kind.SUBSCRIPTION}:
        assert endpoint.qos is not None
        reported = replace(reported, qos=without_times(endpoint.qos))
    else:
        reported = replace(reported, qos=None, type_hash=None)
    assert DIALECT.parse(token) == reported


@pytest.mark.parametrize("kind", [Kind.ACTION_SERVER, Kind.ACTION_CLIENT])
def test_actions_have_tokens(kind: Kind) -> None:
    action = Endpoint(kind, "/spin", "nav2_msgs/action/Spin", BRIDGE)
    token = DIALECT.token(action)
    assert token == f"@/{BRIDGE}/@ros2_lv/{kind.value}/spin/nav2_msgs§action§Spin"
    assert DIALECT.parse(token) == action


@pytest.mark.parametrize(
    ("kind", "text", "qos"),
    [
        ("MP", ":::", Qos(depth=1)),  # DDS defaults differ between writers and readers
        ("MS", ":::", Qos(Reliability.BEST_EFFORT, depth=1)),
        ("MP", "K:1:1:1,-1", Qos(durability=Durability.TRANSIENT_LOCAL, history=History.KEEP_ALL, depth=1)),
        ("MP", ":0:0:0,5:enclave=/;typehash=RIHS01_12;", Qos(Reliability.BEST_EFFORT, depth=5)),
        ("MP", "::", None),
        ("MP", ":9:0:0,5", None),
    ],
)
def test_qos_of_bridges_is_read(kind: str, text: str, qos: Qos | None) -> None:
    endpoint = DIALECT.parse(f"@/{BRIDGE}/@ros2_lv/{kind}/chatter/std_msgs§msg§String/{text}")
    assert isinstance(endpoint, Endpoint)
    assert endpoint.qos == qos
    assert endpoint.type_hash == ("RIHS01_12" if "typehash" in text else None)


@pytest.mark.parametrize(
    "token",
    [
        "",
        f"@/{BRIDGE}/@ros2_lv",
        f"@/{BRIDGE}/@ros2_lv/MP/chatter/std_msgs§msg§String",
        f"@/{BRIDGE}/@ros2_lv/XX/a/b/c",
    ],
)
def test_other_tokens_are_ignored(token: str) -> None:
    assert DIALECT.parse(token) is None


@given(st.text(max_size=60))
def test_any_text_is_read_or_ignored(text: str) -> None:
    for token in (text, f"@/{BRIDGE}/@ros2_lv/MP/a/b/{text}"):
        assert isinstance(DIALECT.parse(token), Endpoint | None)
