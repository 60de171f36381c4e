"""Limits of messages, checked before decoding."""

import struct
import tracemalloc
from typing import Any

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges import wire
from seoro.bridges.executor import messages
from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.wire.limits import MAX_REQUEST, SMALL, LimitExceeded, Limits, check_limits
from sim_nodes import codec
from sim_nodes.codec import CodecError, pack, unpack

MEBIBYTE = 1 << 20
VERBS: tuple[wire.Verb[Any, Any], ...] = (*wire.NODE_VERBS.values(), *EXECUTOR_VERBS.values())


def bomb(size: int) -> bytes:
    """Return an array of empty maps: each byte becomes an object of 64 bytes."""
    return b"\xdd" + struct.pack(">I", size) + b"\x80" * size


def elements(value: Any) -> int:
    match value:
        case dict():
            return 1 + sum(1 + elements(each) for each in value.values())
        case list():
            return 1 + sum(map(elements, value))
        case _:
            return 1


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=300)
    | st.binary(max_size=70_000)
    | st.builds(msgpack.ExtType, st.integers(0, 127), st.binary(max_size=300)),
    lambda inner: st.lists(inner, max_size=40) | st.dictionaries(st.text(), inner, max_size=40),
    max_leaves=100,
)


@given(VALUES)
def test_the_element_count_of_a_payload_is_exact(value: Any) -> None:
    payload, count = msgpack.packb(value), elements(value)
    assert check_limits(payload, Limits(len(payload), count)) == count
    if count > 1:
        with pytest.raises(LimitExceeded, match=f"more than {count - 1} elements"):
            check_limits(payload, Limits(len(payload), count - 1))


@given(st.binary(max_size=200))
def test_arbitrary_bytes_stay_within_the_limits_or_are_refused(payload: bytes) -> None:
    try:
        count = check_limits(payload, SMALL)
    except LimitExceeded:
        return
    assert 0 <= count <= SMALL.items


def test_the_nesting_depth_of_a_payload_is_limited() -> None:
    assert check_limits(b"\x91" * 15 + b"\x90", SMALL) == 16
    with pytest.raises(LimitExceeded, match="16 nested arrays and maps"):
        check_limits(b"\x91" * 16 + b"\x90", SMALL)


@pytest.mark.parametrize("payload", [b"\xdd\xff\xff\xff\xff", b"\xdf\x7f\xff\xff\xff", b"\xdc\xff\xff" * 1000])
def test_elements_announced_by_a_header_count_even_if_missing(payload: bytes) -> None:
    with pytest.raises(LimitExceeded, match="elements"):
        check_limits(payload, SMALL)


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb.name)
def test_refusing_a_large_request_takes_little_memory(verb: wire.Verb[Any, Any]) -> None:
    payload = bomb(min(verb.limits.size, 20 * MEBIBYTE) - 5)
    inside = b"\x81\xa7unknown" + payload[: -len(b"\x81\xa7unknown")]  # an unknown field
    tracemalloc.start()
    try:
        for each in (payload, inside):
            with pytest.raises(wire.WireError):
                verb.read(each)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < MEBIBYTE


def test_only_listed_verbs_have_large_limits() -> None:
    larger = {verb.name for verb in VERBS if verb.limits.size > SMALL.size or verb.limits.items > SMALL.items}
    assert larger == {
        "dry_run", "follow_joint_trajectory", "give_runs", "missing_blobs", "put_blob", "restore_state", "revoke",
        "spawn_entities", "spawn_entity", "submit",
    }  # fmt: skip
    assert max(verb.limits.items for verb in VERBS) <= 100_000
    assert max(verb.limits.size for verb in VERBS) == MAX_REQUEST


def test_a_refusal_does_not_repeat_the_payload() -> None:
    payload = msgpack.packb({"run": "x" * 50_000, "at": ["y" * 1000] * 10, "wait": "soon"})
    with pytest.raises(wire.WireError) as caught:
        messages.RECORDS.read(payload)
    assert len(str(caught.value)) < 600
    assert "xxx" not in str(caught.value)
    assert "yyy" not in str(caught.value)
    assert "wait: Input should be a valid number" in str(caught.value)


def test_a_bundle_with_the_maximum_number_of_files_is_accepted() -> None:
    file = {"path": "a" * 200, "hash": "0" * 64, "size": 1}
    options = {"grace": 1.0, "overrides": {f"name{number}": "1" for number in range(1000)}}
    files = [{**file, "path": f"{number}/{'a' * 200}"} for number in range(messages.MAX_FILES)]
    manifest = {"files": files, "entry": "a", "shown": "a", "options": options}
    asked = {"run": "0" * 32, "manifest": manifest, "sent": ["0" * 64] * messages.MAX_FILES}
    assert len(messages.DRY_RUN.read(msgpack.packb(asked)).manifest.files) == messages.MAX_FILES


def test_a_blob_part_of_maximum_size_is_accepted() -> None:
    part = messages.PutBlob(hash="0" * 64, size=messages.MAX_FILE, offset=0, data=b"x" * messages.CHUNK)
    assert messages.PUT_BLOB.read(wire.encode(part)) == part


def test_a_large_snapshot_is_accepted() -> None:
    snapshot = wire.Snapshot(
        format=3, version="", engine="", engine_version="", world="", seed=0, time=0.0, digest="",
        state=b"x" * (wire.RESTORE_STATE.limits.size - 1000),
    )  # fmt: skip
    assert wire.SAVE_STATE.read_reply(wire.encode(snapshot)) == snapshot
    restore = wire.RestoreState(snapshot=snapshot)
    assert wire.RESTORE_STATE.read(wire.encode(restore)) == restore


def test_the_state_of_a_snapshot_has_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(codec, "MAX_ELEMENTS", 10_000)  # of ten million
    assert unpack(msgpack.packb(msgpack.ExtType(1, bomb(6_000)))) == ({},) * 6_000
    nested = msgpack.ExtType(1, msgpack.packb([msgpack.ExtType(1, bomb(6_000))] * 2))
    with pytest.raises(CodecError, match="elements"):
        unpack(msgpack.packb(nested))
    assert unpack(pack(((1, 2), {"a": (3,)}))) == ((1, 2), {"a": (3,)})
