"""Messages: encoding and refusals."""

import math

import msgpack
import pytest

from seoro.bridges import wire


def test_a_message_survives_the_wire() -> None:
    sent = wire.Advanced(
        time=1.5,
        occurrences=(wire.Occurrence(id="goal-1", time=1.4, outcome=wire.Outcome.ABORTED, message="no way"),),
        contacts=(wire.Contact(time=1.5, first="robot", second="box"),),
    )
    assert wire.decode(wire.Advanced, wire.encode(sent)) == sent


def test_a_message_is_a_plain_map_on_the_wire() -> None:
    plain = {"until": 2.5, "horizon": None, "collects_feedback": False}
    assert msgpack.unpackb(wire.encode(wire.Advance(until=2.5))) == plain


def test_binary_data_stays_binary() -> None:
    artifact = wire.Artifact(name="a.png", media_type="image/png", description="", data=b"\x89PNG\x00")
    assert (
        wire.decode(wire.Artifacts, wire.encode(wire.Artifacts(artifacts=(artifact,)))).artifacts[0].data
        == artifact.data
    )


def test_readers_ignore_fields_of_newer_writers() -> None:
    payload = msgpack.packb({"until": 2.5, "added_later": [1, 2]})
    assert wire.decode(wire.Advance, payload) == wire.Advance(until=2.5)


@pytest.mark.parametrize(
    "payload",
    [b"", b"\xc1", b"not msgpack", msgpack.packb([1, 2]), msgpack.packb({"until": "soon"}), msgpack.packb({})],
)
def test_invalid_payloads_are_a_wire_error(payload: bytes) -> None:
    with pytest.raises(wire.WireError, match="not a valid Advance"):
        wire.decode(wire.Advance, payload)


def test_a_too_large_payload_is_refused_before_decoding() -> None:
    with pytest.raises(wire.WireError, match="exceeds a limit: 11 bytes; expected at most 10"):
        wire.decode(wire.Advance, b"\x00" * 11, wire.Limits(size=10))


def test_every_verb_is_listed_once() -> None:
    names = [verb.name for verb in wire.VERBS]
    assert len(names) == len(set(names)) > 15


def test_keys_have_a_fixed_form() -> None:
    assert wire.node_command("default", "mujoco", "advance") == "seoro/1/default/node/mujoco/cmd/advance"
    token = wire.node_token("default", "mujoco", "b1")
    assert token == "seoro/1/default/alive/node/mujoco/b1"
    assert wire.token_node(token) == ("mujoco", "b1")


@pytest.mark.parametrize("name", ["", "a/b", "*", "@admin", "Ünï", "a b"])
def test_names_that_would_need_escaping_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match=r"invalid name .* of a node"):
        wire.node_command("default", name, "advance")


def test_a_grant_ends_with_the_first_step_that_reaches_its_time() -> None:
    for rate in (200, 240, 250, 500):
        for step in range(2000):
            time = step / rate
            assert wire.steps_until(time, rate) == step
            assert wire.steps_until(math.nextafter(time, math.inf), rate) == step + 1
            assert wire.steps_until(math.nextafter(time, -math.inf), rate) == step


def test_verbs_of_simulators_exclude_those_of_all_nodes_with_robots() -> None:
    shared = wire.NODE_VERBS.keys() - {verb.name for verb in wire.VERBS}
    assert shared == {
        "challenge", "check_robot", "emergency_stop", "get_lab_state", "get_robot_features", "hold_robots",
        "lease_robots", "release_lease", "release_robots", "release_stop", "take_robots",
    }  # fmt: skip


def test_heartbeats_are_sent_several_times_within_their_deadline() -> None:
    assert 3 * wire.HOLD_WAIT < wire.HOLD_DEADLINE < 0.5
    token = wire.holder_token("default", "run-1")
    assert token == f"seoro/1/default/alive/holder/{wire.public_holder_name('run-1')}"
    assert "run-1" not in token
