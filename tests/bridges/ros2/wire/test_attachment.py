"""Attachments of rmw_zenoh."""

from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges.ros2.wire import Attachment

GID = bytes(range(16))
INT64 = st.integers(-(2**63), 2**63 - 1)


def test_an_attachment_has_the_bytes_of_rmw_zenoh() -> None:
    packed = Attachment(1, 1_700_000_000_000_000_000, GID).pack()
    assert packed == bytes.fromhex("0100000000000000 00002a36fe9c9717 10 000102030405060708090a0b0c0d0e0f")
    assert len(packed) == 33


@given(INT64, INT64, st.binary(max_size=64), st.binary(max_size=8))
def test_an_attachment_is_read_with_trailing_bytes(sequence: int, stamp: int, gid: bytes, rest: bytes) -> None:
    attachment = Attachment(sequence, stamp, gid)
    assert Attachment.parse(attachment.pack() + rest) == attachment


@given(st.binary(max_size=32))
def test_a_too_short_attachment_is_refused(payload: bytes) -> None:
    if len(payload) >= 17 and len(payload) - 17 >= payload[16]:
        return
    assert Attachment.parse(payload) is None
