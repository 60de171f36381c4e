"""Requests of clients that hold robots: authentic by a code, and each accepted once."""

from __future__ import annotations

import os
from pathlib import Path

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.signing.answers import AnswerSigner, AnswerVerifier
from seoro.security.signing.replay_window import SIZE, HolderKey, ReplayWindow
from tests.labs import make_lab

BOOT = "b00t"
KEY = "seoro/1/default/node/maze/cmd/cmd_vel"
NAME = b"run-7"
FORWARD = b"forward"
WRONG = "its code is invalid or missing"
REPEATED = "it was received before, or too late"


class Pair:
    """A client that has taken robots of a node, and the node."""

    def __init__(self, folder: Path) -> None:
        lab = make_lab(folder)
        self.node = AnswerSigner(read_keys(lab.keys("maze")), BOOT)
        self.client = AnswerVerifier(read_keys(lab.keys("anna")), "maze", Role.NODE)
        self.client.share(read_keys(lab.keys("maze")).identity, BOOT, self.node.exchange)
        self.take()

    def take(self) -> None:
        public, number = self.client.holder_key()
        self.holder = HolderKey(public, ReplayWindow(number))

    def asked(self, request: bytes = FORWARD, name: bytes = NAME) -> bytes:
        return self.client.prepare(KEY, request, name, has_code=True)[0]

    def check(self, attachment: bytes, request: bytes = FORWARD, key: str = KEY) -> None:
        _, envelope = self.node.open(key, attachment)
        assert envelope is not None
        envelope.check(self.holder, request)
        envelope.check(self.holder, request)  # one that waits is checked again when it is answered


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Pair:
    return Pair(tmp_path_factory.mktemp("lab"))


@pytest.fixture
def pair(made: Pair) -> Pair:
    made.take()
    return made


def test_a_request_is_accepted_once_and_in_any_order(pair: Pair) -> None:
    first, second = pair.asked(), pair.asked()
    pair.check(second)
    pair.check(first)
    for attachment in (first, second):
        with pytest.raises(InvalidKeys, match=REPEATED):
            pair.check(attachment)


def test_a_changed_request_is_refused(pair: Pair) -> None:
    attachment = pair.asked()
    public, boot, (number, code), inner = msgpack.unpackb(attachment)
    with pytest.raises(InvalidKeys, match=WRONG):
        pair.check(attachment, b"backward")
    with pytest.raises(InvalidKeys, match=WRONG):
        pair.check(attachment, key=KEY.replace("cmd_vel", "drive"))
    for changed in (
        (public, boot, (number + 1, code), inner),
        (public, boot, (number, b""), inner),
        (public, boot, (number, code[:-1]), inner),
        (public, "later", (number, code), inner),
        (public, boot, (number, code), b"run-8"),
        (bytes(32), boot, (number, code), inner),
        (b"", boot, (number, code), inner),
    ):
        with pytest.raises(InvalidKeys, match=WRONG):
            pair.check(msgpack.packb(changed))
    pair.check(attachment)


def test_requests_by_the_key_of_another_client_are_refused(pair: Pair, tmp_path: Path) -> None:
    """Keys of the lab and the name of the holder do not help."""
    lab = make_lab(tmp_path)
    other = AnswerVerifier(read_keys(lab.keys("anna")), "maze", Role.NODE)
    other._pair = type(other._pair)()
    other.share(read_keys(lab.keys("maze")).identity, BOOT, pair.node.exchange)
    attachment, _ = other.prepare(KEY, FORWARD, NAME, has_code=True)
    with pytest.raises(InvalidKeys, match=WRONG):
        pair.check(attachment)


@pytest.mark.parametrize("exchange", [b"", bytes(32)])
def test_requests_of_a_holder_without_a_valid_key_are_refused(pair: Pair, exchange: bytes) -> None:
    public, boot, numbered, inner = msgpack.unpackb(pair.asked())
    pair.holder = HolderKey(exchange, ReplayWindow())
    for each in (public, exchange):
        with pytest.raises(InvalidKeys, match=WRONG):
            pair.check(msgpack.packb((each, boot, numbered, inner)))


def test_requests_of_an_earlier_hold_are_refused(pair: Pair) -> None:
    before = pair.asked()
    pair.take()
    with pytest.raises(InvalidKeys, match=REPEATED):
        pair.check(before)
    pair.check(pair.asked())


@given(
    floor=st.integers(0, 5),
    steps=st.lists(st.integers(0, 12) | st.integers(0, 3 * SIZE) | st.just(2**63), max_size=60),
)
def test_a_window_accepts_each_number_once(floor: int, steps: list[int]) -> None:
    window, used, highest = ReplayWindow(floor), set[int](), floor
    for number in steps:
        expected = number > floor and number not in used and number > highest - SIZE
        assert window.accept(number) is expected
        if expected:
            used.add(number)
        highest = max(highest, number)
    assert window._used.bit_length() <= SIZE


def test_a_forked_process_has_its_own_key_pair_even_with_an_equal_process_id(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Process ids restart in a sandbox."""
    monkeypatch.setattr(os, "getpid", lambda: 7)
    keys = read_keys(make_lab(tmp_path).keys("anna"))
    own, _ = AnswerVerifier(keys, "maze", Role.NODE).holder_key()
    assert own == AnswerVerifier(keys, "maze", Role.NODE).holder_key()[0]
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.write(writing, AnswerVerifier(keys, "maze", Role.NODE).holder_key()[0])
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        forked = pipe.read()
    assert len(forked) == len(own)
    assert forked != own
