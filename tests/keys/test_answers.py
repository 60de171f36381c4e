"""Answers that are authentic: whatever is changed between who answers and who asks is noticed."""

from __future__ import annotations

from pathlib import Path

import msgpack
import pytest

from seoro.keys.answers import Answers, Check, Checker
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys, read_keys
from seoro.keys.roles import Role
from tests.labs import NAME, KeyedLab, make_lab

BOOT = "b00t"
KEY = "seoro/1/default/exec/lab-a/cmd/get_run"
REQUEST = b"what has become of it"
PASSED, FAILED = b"passed", b"failed"
WRONG = "the signature is wrong"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    made = make_lab(tmp_path_factory.mktemp("lab"))
    made.authority.add("lab-b", Role.EXECUTOR, made.keys("lab-b"))
    return made


@pytest.fixture(scope="module")
def executor(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


@pytest.fixture
def there(executor: Keys) -> Answers:
    return Answers(executor, BOOT)


@pytest.fixture
def client(lab: KeyedLab) -> Checker:
    """Who has had the executor prove who it is."""
    return Checker(read_keys(lab.keys("anna")), NAME, Role.EXECUTOR)


def shared(client: Checker, there: Answers) -> Checker:
    client.share(there._keys.identity, BOOT, there.exchange)
    return client


def answered(there: Answers, beside: bytes, answer: bytes, request: bytes = REQUEST, key: str = KEY) -> bytes:
    """What the executor sends beside an answer."""
    inner, envelope = there.open(key, beside)
    assert inner == b"seal"
    assert envelope is not None
    return envelope.attest(request, 0, 0, answer)


def asked(client: Checker) -> tuple[bytes, Check]:
    return client.prepare(KEY, REQUEST, b"seal")


def test_an_answer_is_authentic_by_a_shared_secret(client: Checker, there: Answers) -> None:
    beside, check = asked(shared(client, there))
    attested = answered(there, beside, PASSED)
    assert not check(PASSED, attested).is_signed
    assert len(attested) < 40


def test_an_answer_to_one_without_a_secret_is_signed(client: Checker, there: Answers) -> None:
    beside, check = asked(client)
    assert check(PASSED, answered(there, beside, PASSED)).is_signed


def test_an_executor_that_was_restarted_signs(client: Checker, there: Answers, executor: Keys) -> None:
    shared(client, there)
    beside, check = asked(client)
    assert check(PASSED, answered(Answers(executor, "later"), beside, PASSED)).is_signed


@pytest.mark.parametrize("is_shared", [True, False])
def test_a_changed_answer_is_refused(client: Checker, there: Answers, *, is_shared: bool) -> None:
    beside, check = asked(shared(client, there) if is_shared else client)
    attested = answered(there, beside, FAILED)
    assert check(FAILED, attested)
    with pytest.raises(InvalidKeys, match=WRONG):
        check(PASSED, attested)
    form, number, code, signature = msgpack.unpackb(attested)
    for changed in ((1, number, code, signature), (form, 1, code, signature), (form, number, b"", code)):
        with pytest.raises(InvalidKeys):
            check(FAILED, msgpack.packb(changed))


@pytest.mark.parametrize("is_shared", [True, False])
def test_an_answer_to_another_request_is_refused(client: Checker, there: Answers, *, is_shared: bool) -> None:
    """Also one to the same request, said before."""
    asking = shared(client, there) if is_shared else client
    before, _ = asked(asking)
    _, check = asked(asking)
    with pytest.raises(InvalidKeys, match=WRONG):
        check(PASSED, answered(there, before, PASSED))
    beside, check = asked(asking)
    for attested in (
        answered(there, beside, PASSED, request=b"what has become of another"),
        answered(there, beside, PASSED, key=KEY.replace("get_run", "list_runs")),
    ):
        with pytest.raises(InvalidKeys, match=WRONG):
            check(PASSED, attested)


def test_what_is_not_signed_is_refused(client: Checker, there: Answers) -> None:
    _, check = asked(shared(client, there))
    with pytest.raises(InvalidKeys, match="it is not signed"):
        check(PASSED, b"")
    for attested in (b"part", b"\xc1", msgpack.packb([0, 0, b""]), msgpack.packb([0, True, b"x" * 32, b""])):
        with pytest.raises(InvalidKeys, match="its signature is invalid"):
            check(PASSED, attested)
    with pytest.raises(InvalidKeys, match="it is not signed"):
        check(PASSED, msgpack.packb([0, 0, b"", b""]))


@pytest.mark.parametrize("name", ["lab-b", "anna"])
def test_another_identity_of_the_lab_cannot_answer(
    client: Checker, there: Answers, lab: KeyedLab, name: str
) -> None:
    shared(client, there)
    beside, check = asked(client)
    other = read_keys(lab.keys(name))
    with pytest.raises(InvalidKeys, match=rf"it is signed with the keys of {name}"):
        check(PASSED, answered(Answers(other, "another"), beside, PASSED))
    with pytest.raises(InvalidKeys, match=WRONG):  # by a secret of its own
        check(PASSED, answered(Answers(other, BOOT), beside, PASSED))


def test_another_lab_cannot_answer(client: Checker, tmp_path: Path) -> None:
    other = Answers(read_keys(make_lab(tmp_path).keys(NAME)), BOOT)
    beside, check = asked(client)
    with pytest.raises(InvalidKeys, match="was not signed by the lab"):
        check(PASSED, answered(other, beside, PASSED))


def test_keys_of_no_point_share_nothing(client: Checker, there: Answers) -> None:
    """Of small order: whoever puts them in the place of others would know the secret."""
    with pytest.raises(InvalidKeys, match="the key for its answers is invalid"):
        client.share(there._keys.identity, BOOT, bytes(32))
    _, envelope = there.open(KEY, msgpack.packb([bytes(32), BOOT, (1, b""), b"seal"]))
    assert envelope is not None
    assert msgpack.unpackb(envelope.attest(REQUEST, 0, 0, PASSED))[2] == b""  # it signs


@pytest.mark.parametrize("beside", [b"", b"\x94", b"\x94abcd", msgpack.packb([1, BOOT, 1, b"x"]), b"\x95seal"])
def test_what_asks_for_no_authentic_answer_is_left_as_it_is(there: Answers, beside: bytes) -> None:
    assert there.open(KEY, beside) == (beside, None)
