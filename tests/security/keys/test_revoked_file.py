"""Clients that read the revocation list in their key folder, also while connected."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.security.keys import revocation
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import KeyFolder, Keys, read_keys
from seoro.security.keys.revocation import RevokedFile, read_list
from seoro.security.keys.roles import Role
from seoro.security.signing.answers import AnswerSigner, AnswerVerifier, Check
from seoro.security.signing.commands import CommandSigner, prove
from seoro.security.signing.statements import certificate_der
from tests.labs import NAME, KeyedLab, make_lab

BOOT = "b00t"
KEY = f"seoro/1/default/exec/{NAME}/cmd/get_run"
REVOKED = rf"{NAME} \(executor\) is revoked"
NONCE, EXCHANGE = b"0" * 16, b"1" * 32


@pytest.fixture(autouse=True)
def look_always(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(revocation, "PERIOD", 0.0)


@pytest.fixture
def lab(tmp_path: Path) -> KeyedLab:
    return make_lab(tmp_path)


@pytest.fixture
def executor(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


@pytest.fixture
def anna(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys("anna"))


def connect(client: Keys, executor: Keys) -> CommandSigner:
    """Verify the identity of the executor."""
    made, now = CommandSigner(client, NAME), time.time_ns()
    proof = prove(executor, NAME, NONCE, BOOT, now, EXCHANGE)
    made.accept(certificate_der(executor.certificate), proof, NONCE, BOOT, now, (now, now), EXCHANGE)
    return made


def asked(client: AnswerVerifier, there: AnswerSigner) -> tuple[Check, bytes]:
    attachment, check = client.prepare(KEY, b"?", b"seal")
    _, envelope = there.open(KEY, attachment)
    assert envelope is not None
    return check, envelope.attest(b"?", 0, 0, b"passed")


def test_the_proof_of_a_revoked_executor_is_refused(lab: KeyedLab, anna: Keys, executor: Keys) -> None:
    lab.revoke(NAME)
    connect(anna, executor)  # the list is missing
    KeyFolder(lab.keys("anna")).revoked.write_bytes((lab.path / "ca" / "revoked.crl").read_bytes())
    with pytest.raises(InvalidKeys, match=REVOKED) as caught:
        connect(anna, executor)
    assert str(lab.keys("anna") / "revoked.crl") in (caught.value.help or "")


@pytest.mark.parametrize("is_shared", [True, False])
def test_answers_are_refused_after_a_revocation(
    lab: KeyedLab, anna: Keys, executor: Keys, *, is_shared: bool
) -> None:
    there, client = AnswerSigner(executor, BOOT), AnswerVerifier(anna, NAME, Role.EXECUTOR)
    if is_shared:
        client.share(executor.identity, BOOT, there.exchange)
    check, attested = asked(client, there)
    assert check(b"passed", attested).is_signed != is_shared
    lab.revoke(NAME, "anna")
    check, attested = asked(client, there)
    with pytest.raises(InvalidKeys, match=REVOKED):
        check(b"passed", attested)


def test_an_invalid_revocation_list_is_reported(lab: KeyedLab, anna: Keys, executor: Keys, tmp_path: Path) -> None:
    file = KeyFolder(lab.keys("anna")).revoked
    for invalid in (b"nothing", (make_lab(tmp_path / "other").path / "ca" / "revoked.crl").read_bytes()):
        file.write_bytes(invalid)
        with pytest.raises(InvalidKeys, match="cannot read the list of revoked keys"):
            connect(anna, executor)
    file.unlink()
    connect(anna, executor)  # keys of earlier versions came without a list


def test_an_invalid_or_older_revocation_list_is_ignored(
    lab: KeyedLab, anna: Keys, executor: Keys, caplog: pytest.LogCaptureFixture
) -> None:
    file = KeyFolder(lab.keys("anna")).revoked
    older = file.read_bytes()
    lab.revoke(NAME, "anna")
    reading = RevokedFile(anna)
    assert reading.current().contains(executor.identity.serial)
    for content in (b"half of it", older):
        file.write_bytes(content)
        assert reading.current().contains(executor.identity.serial)
        assert reading.current().contains(executor.identity.serial)  # logged once
    file.unlink()
    assert reading.current().contains(executor.identity.serial)
    assert [record.getMessage().endswith("; using the previous list") for record in caplog.records] == [
        True,
        True,
    ]


def test_a_sandboxed_run_has_a_revocation_list(lab: KeyedLab, anna: Keys, executor: Keys) -> None:
    """The broker sends the list to the sandboxed run."""
    lab.revoke(NAME)
    known = read_list(lab.path / "ca" / "revoked.crl", anna.authority)
    with pytest.raises(InvalidKeys, match=REVOKED):
        connect(replace(anna, folder=KeyFolder(Path("/nowhere")), revoked=known), executor)
