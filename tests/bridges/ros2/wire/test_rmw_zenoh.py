"""Dialect of rmw_zenoh: examples of its design document, and tokens that it must parse."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges.ros2.wire import Durability, Endpoint, History, Kind, Node, Qos, Reliability, RmwZenoh
from seoro.bridges.ros2.wire.rmw_zenoh import NO_HASH, decode_qos, encode_qos
from tests.bridges.ros2.wire.systems import HASHES, NAMES, NODES, QOS, TYPES, endpoints

STRING = "std_msgs/msg/String"
STRING_HASH = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD = "example_interfaces/srv/AddTwoInts"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
SESSION = "aac3178e146ba6f1fc6e6a4085e77f21"
TALKER = Node(SESSION, 0, "talker")
DIALECT = RmwZenoh()
GID = "34e0f0eaf0a5e0c897d90e747bb8850d"


def test_topics_and_services_have_keys_of_rmw_zenoh() -> None:
    assert DIALECT.key("/chatter", STRING, STRING_HASH) == f"0/chatter/std_msgs::msg::dds_::String_/{STRING_HASH}"
    assert (
        RmwZenoh(2).key("/add_two_ints", ADD, ADD_HASH)
        == f"2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}"
    )
    assert DIALECT.key_expression("/bot/scan", "a_msgs/msg/A") == "0/bot/scan/a_msgs::msg::dds_::A_/*"
    assert DIALECT.key("/bot/scan", "a_msgs/msg/A", None) == f"0/bot/scan/a_msgs::msg::dds_::A_/{NO_HASH}"


@given(NAMES, TYPES, HASHES)
def test_keys_contain_the_type_hash(name: str, type_name: str, type_hash: str | None) -> None:
    assert DIALECT.type_hash(DIALECT.key(name, type_name, type_hash)) == type_hash


def test_tokens_equal_those_of_the_design_document() -> None:
    assert DIALECT.token(TALKER) == f"@ros2_lv/0/{SESSION}/0/0/NN/%/%/talker"
    chatter = Endpoint(Kind.PUBLISHER, "/chatter", STRING, SESSION, STRING_HASH, Qos(), 10, TALKER)
    assert DIALECT.token(chatter) == (
        f"@ros2_lv/0/{SESSION}/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_/{STRING_HASH}/1:2:1,10:,:,:,,"
    )
    server = Endpoint(
        Kind.SERVER, "/a/add", ADD, SESSION, ADD_HASH, Qos(), 3, replace(TALKER, number=2, namespace="/a/b")
    )
    assert DIALECT.token(server) == (
        f"@ros2_lv/0/{SESSION}/2/3/SS/%/%a%b/talker/%a%add/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}"
        "/1:2:1,10:,:,:,,"
    )


@given(NODES | endpoints(), st.integers(0, 232))
def test_announcements_are_read_with_trailing_parts(entity: Node | Endpoint, domain: int) -> None:
    dialect = RmwZenoh(domain)
    token = dialect.token(entity)
    assert token is not None
    assert dialect.parse(token) == entity
    assert dialect.parse(token + "/cpu,cuda") == entity


@pytest.mark.parametrize(
    "token",
    [
        "",
        "@ros2_lv",
        "@ros2_lv/0/**",
        f"@ros2_lv/0/{SESSION}/x/0/NN/%/%/talker",
        f"@ros2_lv/0/{SESSION}/0/0/XX/%/%/talker",
        f"@ros2_lv/0/{SESSION}/{'9' * 5000}/0/NN/%/%/talker",
        f"@ros2_lv/0/{SESSION}/0/{'9' * 5000}/MP/%/%/talker/%a/a_msgs::msg::dds_::A_/{NO_HASH}/::,:,:,:,,",
        f"@ros2_lv/0/{SESSION}//0/NN/%/%/talker",
        f"@ros2_lv/0/{SESSION}/0/10/MP/%/%/talker/%chatter/std_msgs::msg::dds_::String_",
        f"@/{SESSION}/@ros2_lv/MP/chatter/std_msgs§msg§String/:1:0:0,10",
        "seoro/1/default/alive/node/a/b/c/d/e/f/g/h",
    ],
)
def test_other_tokens_are_ignored(token: str) -> None:
    assert DIALECT.parse(token) is None


@given(st.text(max_size=80))
def test_any_text_is_read_or_ignored(text: str) -> None:
    for token in (text, f"@ros2_lv/0/{SESSION}/0/10/MP/%/%/{text}"):
        assert isinstance(DIALECT.parse(token), Node | Endpoint | None)
    assert isinstance(decode_qos(text), Qos | None)


@given(QOS)
def test_written_qos_is_read_back(qos: Qos) -> None:
    assert decode_qos(encode_qos(qos)) == qos


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        ("::,:,:,:,,", Qos(depth=42)),  # all is rmw_zenoh's default
        ("::,10:,:,:,,", Qos(depth=10)),
        ("2::,5:,:,:,,", Qos(Reliability.BEST_EFFORT, depth=5)),
        (":1:,1:,:,:,,", Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)),
        ("1:2:2,0:,:,:,,", Qos(history=History.KEEP_ALL, depth=42)),
        ("::,7:1,500000000:,:,,", Qos(depth=7, deadline=1_500_000_000)),
        ("::,7:0,0:9223372036,854775807:1,,", Qos(depth=7)),  # durations that are unspecified, and without end
        ("::,10:,:,:,,:new", Qos(depth=10)),
    ],
)
def test_qos_of_other_implementations_is_read(text: str, qos: Qos) -> None:
    assert decode_qos(text) == qos


@pytest.mark.parametrize(
    "text",
    [
        "",
        "::",
        "9::,10:,:,:,,",
        "::,x:,:,:,,",
        "::,10:,:,:,",
        "::10:,:,:,,",
        "::,-1:,:,:,,",
        f"::,{'9' * 5000}:,:,:,,",
    ],
)
def test_invalid_qos_is_read_as_none(text: str) -> None:
    assert decode_qos(text) is None


def test_a_gid_is_the_hash_of_a_token() -> None:
    # By rmw_zenoh's own hash function (simplified_xxhash3.cpp), the lower half first.
    assert DIALECT.gid("@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/talker").hex() == GID


def test_domains_out_of_range_are_refused() -> None:
    with pytest.raises(ValueError, match="0 to 232"):
        RmwZenoh(233)
