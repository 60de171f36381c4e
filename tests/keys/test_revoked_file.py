"""Clients that read who is revoked: in the folder of their keys, also while they are connected."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.keys import revoked_file
from seoro.keys.answers import Answers, Check, Checker
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import KeyFolder, Keys, read_keys
from seoro.keys.revocation import read_list
from seoro.keys.revoked_file import RevokedFile
from seoro.keys.roles import Role
from seoro.keys.sealing import Sealer, prove
from seoro.keys.signing import certificate_der
from tests.labs import NAME, KeyedLab, make_lab

BOOT = "b00t"
KEY = f"seoro/1/default/exec/{NAME}/cmd/get_run"
REVOKED = rf"{NAME} \(executor\) is revoked"
NONCE, EXCHANGE = b"0" * 16, b"1" * 32


@pytest.fixture(autouse=True)
def look_always(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(revoked_file, "PERIOD", 0.0)


@pytest.fixture
def lab(tmp_path: Path) -> KeyedLab:
    return make_lab(tmp_path)


@pytest.fixture
def executor(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


@pytest.fixture
def anna(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys("anna"))


def connect(client: Keys, executor: Keys) -> Sealer:
    """Have the executor prove who it is."""
    made, now = Sealer(client, NAME), time.time_ns()
    proof = prove(executor, NAME, NONCE, BOOT, now, EXCHANGE)
    made.accept(certificate_der(executor.certificate), proof, NONCE, BOOT, now, (now, now), EXCHANGE)
    return made


def asked(client: Checker, there: Answers) -> tuple[Check, bytes]:
    beside, check = client.prepare(KEY, b"?", b"seal")
    _, envelope = there.open(KEY, beside)
    assert envelope is not None
    return check, envelope.attest(b"?", 0, 0, b"passed")


def test_a_revoked_executor_proves_nothing(lab: KeyedLab, anna: Keys, executor: Keys) -> None:
    lab.revoke(NAME)
    connect(anna, executor)  # nobody has brought the list
    KeyFolder(lab.keys("anna")).revoked.write_bytes((lab.path / "ca" / "revoked.crl").read_bytes())
    with pytest.raises(InvalidKeys, match=REVOKED) as caught:
        connect(anna, executor)
    assert str(lab.keys("anna") / "revoked.crl") in (caught.value.help or "")


@pytest.mark.parametrize("is_shared", [True, False])
def test_answers_of_who_is_revoked_meanwhile_are_refused(
    lab: KeyedLab, anna: Keys, executor: Keys, *, is_shared: bool
) -> None:
    there, client = Answers(executor, BOOT), Checker(anna, NAME, Role.EXECUTOR)
    if is_shared:
        client.share(executor.identity, BOOT, there.exchange)
    check, attested = asked(client, there)
    assert check(b"passed", attested).is_signed != is_shared
    lab.revoke(NAME, "anna")
    check, attested = asked(client, there)
    with pytest.raises(InvalidKeys, match=REVOKED):
        check(b"passed", attested)


def test_an_invalid_list_is_reported(lab: KeyedLab, anna: Keys, executor: Keys, tmp_path: Path) -> None:
    file = KeyFolder(lab.keys("anna")).revoked
    for invalid in (b"nothing", (make_lab(tmp_path / "other").path / "ca" / "revoked.crl").read_bytes()):
        file.write_bytes(invalid)
        with pytest.raises(InvalidKeys, match="it is not known who is revoked"):
            connect(anna, executor)
    file.unlink()
    connect(anna, executor)  # keys of earlier versions came without a list


def test_a_later_list_that_is_invalid_or_older_changes_nothing(
    lab: KeyedLab, anna: Keys, executor: Keys, caplog: pytest.LogCaptureFixture
) -> None:
    file = KeyFolder(lab.keys("anna")).revoked
    older = file.read_bytes()
    lab.revoke(NAME, "anna")
    reading = RevokedFile(anna)
    assert reading.current().has(executor.identity.serial)
    for content in (b"half of it", older):
        file.write_bytes(content)
        assert reading.current().has(executor.identity.serial)
        assert reading.current().has(executor.identity.serial)  # which is logged once
    file.unlink()
    assert reading.current().has(executor.identity.serial)
    assert [record.getMessage().endswith("; the list before it holds") for record in caplog.records] == [
        True,
        True,
    ]


def test_who_cannot_read_the_folder_has_a_list(lab: KeyedLab, anna: Keys, executor: Keys) -> None:
    """A run in a sandbox, which the broker gives it."""
    lab.revoke(NAME)
    known = read_list(lab.path / "ca" / "revoked.crl", anna.authority)
    with pytest.raises(InvalidKeys, match=REVOKED):
        connect(replace(anna, folder=KeyFolder(Path("/nowhere")), revoked=known), executor)
