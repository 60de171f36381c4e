"""Authenticated answers: every change between server and client is detected."""

from __future__ import annotations

from pathlib import Path

import msgpack
import pytest

from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.keys.roles import Role
from seoro.security.signing.answers import AnswerSigner, AnswerVerifier, Check
from tests.labs import NAME, KeyedLab, make_lab

BOOT = "b00t"
KEY = "seoro/1/default/exec/lab-a/cmd/get_run"
REQUEST = b"what has become of it"
PASSED, FAILED = b"passed", b"failed"
WRONG = "invalid signature"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    made = make_lab(tmp_path_factory.mktemp("lab"))
    made.authority.add("lab-b", Role.EXECUTOR, made.keys("lab-b"))
    return made


@pytest.fixture(scope="module")
def executor(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


@pytest.fixture
def there(executor: Keys) -> AnswerSigner:
    return AnswerSigner(executor, BOOT)


@pytest.fixture
def client(lab: KeyedLab) -> AnswerVerifier:
    """Return a client with a proof of the executor."""
    return AnswerVerifier(read_keys(lab.keys("anna")), NAME, Role.EXECUTOR)


def shared(client: AnswerVerifier, there: AnswerSigner) -> AnswerVerifier:
    client.share(there._keys.identity, BOOT, there.exchange)
    return client


def answered(
    there: AnswerSigner, attachment: bytes, answer: bytes, request: bytes = REQUEST, key: str = KEY
) -> bytes:
    """Return the attachment of an answer of the executor."""
    inner, envelope = there.open(key, attachment)
    assert inner == b"seal"
    assert envelope is not None
    return envelope.attest(request, 0, 0, answer)


def asked(client: AnswerVerifier) -> tuple[bytes, Check]:
    return client.prepare(KEY, REQUEST, b"seal")


def test_an_answer_is_authenticated_by_a_shared_secret(client: AnswerVerifier, there: AnswerSigner) -> None:
    attachment, check = asked(shared(client, there))
    attested = answered(there, attachment, PASSED)
    assert not check(PASSED, attested).is_signed
    assert len(attested) < 40


def test_an_answer_without_a_shared_secret_is_signed(client: AnswerVerifier, there: AnswerSigner) -> None:
    attachment, check = asked(client)
    assert check(PASSED, answered(there, attachment, PASSED)).is_signed


def test_a_restarted_executor_signs_its_answers(
    client: AnswerVerifier, there: AnswerSigner, executor: Keys
) -> None:
    shared(client, there)
    attachment, check = asked(client)
    assert check(PASSED, answered(AnswerSigner(executor, "later"), attachment, PASSED)).is_signed


@pytest.mark.parametrize("is_shared", [True, False])
def test_a_changed_answer_is_refused(client: AnswerVerifier, there: AnswerSigner, *, is_shared: bool) -> None:
    attachment, check = asked(shared(client, there) if is_shared else client)
    attested = answered(there, attachment, FAILED)
    assert check(FAILED, attested)
    with pytest.raises(InvalidKeys, match=WRONG):
        check(PASSED, attested)
    form, number, code, signature = msgpack.unpackb(attested)
    for changed in ((1, number, code, signature), (form, 1, code, signature), (form, number, b"", code)):
        with pytest.raises(InvalidKeys):
            check(FAILED, msgpack.packb(changed))


@pytest.mark.parametrize("is_shared", [True, False])
def test_an_answer_to_another_request_is_refused(
    client: AnswerVerifier, there: AnswerSigner, *, is_shared: bool
) -> None:
    """An earlier answer to the same request is refused, too."""
    asking = shared(client, there) if is_shared else client
    before, _ = asked(asking)
    _, check = asked(asking)
    with pytest.raises(InvalidKeys, match=WRONG):
        check(PASSED, answered(there, before, PASSED))
    attachment, check = asked(asking)
    for attested in (
        answered(there, attachment, PASSED, request=b"what has become of another"),
        answered(there, attachment, PASSED, key=KEY.replace("get_run", "list_runs")),
    ):
        with pytest.raises(InvalidKeys, match=WRONG):
            check(PASSED, attested)


def test_unsigned_answers_are_refused(client: AnswerVerifier, there: AnswerSigner) -> None:
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
    client: AnswerVerifier, there: AnswerSigner, lab: KeyedLab, name: str
) -> None:
    shared(client, there)
    attachment, check = asked(client)
    other = read_keys(lab.keys(name))
    with pytest.raises(InvalidKeys, match=rf"signed with the keys of {name}"):
        check(PASSED, answered(AnswerSigner(other, "another"), attachment, PASSED))
    with pytest.raises(InvalidKeys, match=WRONG):  # by a secret of its own
        check(PASSED, answered(AnswerSigner(other, BOOT), attachment, PASSED))


def test_another_lab_cannot_answer(client: AnswerVerifier, tmp_path: Path) -> None:
    other = AnswerSigner(read_keys(make_lab(tmp_path).keys(NAME)), BOOT)
    attachment, check = asked(client)
    with pytest.raises(InvalidKeys, match="was not signed by the lab"):
        check(PASSED, answered(other, attachment, PASSED))


def test_exchange_keys_of_small_order_are_refused(client: AnswerVerifier, there: AnswerSigner) -> None:
    """Keys of small order: an attacker who substitutes them would know the secret."""
    with pytest.raises(InvalidKeys, match="invalid public key for its answers"):
        client.share(there._keys.identity, BOOT, bytes(32))
    _, envelope = there.open(KEY, msgpack.packb([bytes(32), BOOT, (1, b""), b"seal"]))
    assert envelope is not None
    assert msgpack.unpackb(envelope.attest(REQUEST, 0, 0, PASSED))[2] == b""  # it signs


@pytest.mark.parametrize("attachment", [b"", b"\x94", b"\x94abcd", msgpack.packb([1, BOOT, 1, b"x"]), b"\x95seal"])
def test_attachments_without_a_challenge_are_not_changed(there: AnswerSigner, attachment: bytes) -> None:
    assert there.open(KEY, attachment) == (attachment, None)
