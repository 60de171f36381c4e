"""Signatures of commands: they prove the sender over any transport."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.errors import UsageError
from seoro.security.keys.files import read_pair
from seoro.security.keys.folder import KeyFolder, Keys, read_keys
from seoro.security.keys.revocation import Revocations, read_list
from seoro.security.keys.roles import Role
from seoro.security.signing.commands import (
    WINDOW,
    CommandSigner,
    CommandVerifier,
    StaleCommand,
    prove,
    sign_emergency_stop,
)
from seoro.security.signing.statements import certificate_der
from tests.labs import NAME, KeyedLab, make_lab

KEY = f"seoro/1/default/exec/{NAME}/cmd/submit"
BOOT = "b00t"
NONCE = bytes(16)
EXCHANGE = bytes(range(32))


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture
def executor(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


def verifier(keys: Keys, clock: Callable[[], int] = time.time_ns, boot: str = BOOT) -> CommandVerifier:
    return CommandVerifier(keys, boot, lambda: Revocations(0), clock)


def signer(
    lab: KeyedLab, executor: Keys, name: str = "anna", now: int | None = None, boot: str = BOOT
) -> CommandSigner:
    made = CommandSigner(read_keys(lab.keys(name)), NAME)
    stamp = time.time_ns() if now is None else now
    proof = prove(executor, NAME, NONCE, boot, stamp, EXCHANGE)
    here = time.time_ns()
    made.accept(certificate_der(executor.certificate), proof, NONCE, boot, stamp, (here, here), EXCHANGE)
    return made


def test_a_signature_identifies_the_signer(lab: KeyedLab, executor: Keys) -> None:
    assert verifier(executor).verify(KEY, b"x", signer(lab, executor).sign(KEY, b"x")).name == "anna"


def test_a_replayed_command_is_refused(lab: KeyedLab, executor: Keys) -> None:
    there, seal = verifier(executor), signer(lab, executor).sign(KEY, b"x")
    there.verify(KEY, b"x", seal)
    with pytest.raises(UsageError, match="received before"):
        there.verify(KEY, b"x", seal)


def test_a_signature_is_valid_for_one_command_to_one_executor(lab: KeyedLab, executor: Keys) -> None:
    there, seal = verifier(executor), signer(lab, executor).sign(KEY, b"x")
    other = "seoro/1/default/exec/lab-b/cmd/submit"
    for key, payload in ((KEY, b"y"), (KEY.replace("submit", "stop_run"), b"x"), (other, b"x")):
        with pytest.raises(UsageError, match="invalid signature"):
            there.verify(key, payload, seal)


def test_a_signature_is_valid_for_one_start_of_the_executor(lab: KeyedLab, executor: Keys) -> None:
    seal = signer(lab, executor).sign(KEY, b"x")
    with pytest.raises(StaleCommand, match="an earlier start"):
        verifier(executor, boot="an0ther").verify(KEY, b"x", seal)


def test_a_signature_expires(lab: KeyedLab, executor: Keys) -> None:
    seal = signer(lab, executor).sign(KEY, b"x")
    later = time.time_ns() + int((WINDOW + 1.0) * 1e9)
    with pytest.raises(StaleCommand, match="the time of the command"):
        verifier(executor, clock=lambda: later).verify(KEY, b"x", seal)


def test_clocks_of_signer_and_verifier_may_differ(lab: KeyedLab, executor: Keys) -> None:
    ahead = 3600 * 10**9
    made = signer(lab, executor, now=time.time_ns() + ahead)
    there = verifier(executor, clock=lambda: time.time_ns() + ahead)
    assert there.verify(KEY, b"x", made.sign(KEY, b"x")).name == "anna"


def test_a_revoked_signer_is_refused(lab: KeyedLab, executor: Keys, tmp_path: Path) -> None:
    lab.authority.add("rob", read_keys(lab.keys("anna")).identity.role, tmp_path / "rob")
    lab.authority.revoke("rob")
    revoked = read_list(lab.path / "ca" / "revoked.crl", executor.authority)
    made = CommandSigner(read_keys(tmp_path / "rob"), NAME)
    there = CommandVerifier(executor, BOOT, lambda: revoked)
    with pytest.raises(UsageError, match=r"rob \(operator\) is revoked"):
        there.verify(KEY, b"x", made.sign(KEY, b"x"))


def test_a_signer_of_another_lab_is_refused(lab: KeyedLab, executor: Keys, tmp_path: Path) -> None:
    other = make_lab(tmp_path)
    seal = CommandSigner(read_keys(other.keys("ada")), NAME).sign(KEY, b"x")
    with pytest.raises(UsageError, match="not signed by the lab"):
        verifier(executor).verify(KEY, b"x", seal)


@pytest.mark.parametrize("seal", [b"", b"\xc1", b"x", b"\x95\x01\x02\x03\x04\x05", bytes(10_000)])
def test_invalid_signatures_are_refused(executor: Keys, seal: bytes) -> None:
    with pytest.raises(UsageError, match=r"signed commands only|invalid signature"):
        verifier(executor).verify(KEY, b"x", seal)


def test_a_proof_by_another_executor_is_refused(lab: KeyedLab) -> None:
    made = CommandSigner(read_keys(lab.keys("anna")), NAME)
    now = time.time_ns()
    for name in ("maze", "ada"):
        other = read_keys(lab.keys(name))
        proof = prove(other, NAME, NONCE, BOOT, now, EXCHANGE)
        with pytest.raises(UsageError, match=f"it answers with the keys of {name}"):
            made.accept(certificate_der(other.certificate), proof, NONCE, BOOT, now, (now, now), EXCHANGE)


def test_a_proof_for_another_nonce_is_refused(lab: KeyedLab, executor: Keys) -> None:
    made, now = CommandSigner(read_keys(lab.keys("anna")), NAME), time.time_ns()
    proof = prove(executor, NAME, NONCE, BOOT, now, EXCHANGE)
    with pytest.raises(UsageError, match="invalid signature"):
        made.accept(certificate_der(executor.certificate), proof, b"1" * 16, BOOT, now, (now, now), EXCHANGE)


def test_setting_the_clock_back_admits_no_replay(lab: KeyedLab, executor: Keys) -> None:
    """The replay is refused even if its nonce was dropped meanwhile."""
    clock, made = [time.time_ns()], signer(lab, executor)
    there, old = verifier(executor, clock=lambda: clock[0]), made.sign(KEY, b"x")
    there.verify(KEY, b"x", old)
    began, later = clock[0], clock[0] + int((2.0 * WINDOW + 1.0) * 1e9)
    clock[0] = later
    for _ in range(3):
        there.verify(KEY, b"x", signer(lab, executor, now=later).sign(KEY, b"x"))
    clock[0] = began
    with pytest.raises(UsageError, match=r"statement before|the time of the command"):
        there.verify(KEY, b"x", old)


def test_a_jump_of_the_date_admits_no_replay(
    lab: KeyedLab, executor: Keys, monkeypatch: pytest.MonkeyPatch
) -> None:
    there, seal = CommandVerifier(executor, BOOT, lambda: Revocations(0)), signer(lab, executor).sign(KEY, b"x")
    there.verify(KEY, b"x", seal)
    now = time.time_ns()
    monkeypatch.setattr("time.time_ns", lambda: now - 3600 * 10**9)
    with pytest.raises(UsageError, match="received before"):
        there.verify(KEY, b"x", seal)


def test_the_memory_for_nonces_is_bounded(lab: KeyedLab, executor: Keys) -> None:
    clock, made = [time.time_ns()], signer(lab, executor)
    there = verifier(executor, clock=lambda: clock[0])
    for _ in range(50):
        there.verify(KEY, b"x", made.sign(KEY, b"x"))
    clock[0] += int(2.5 * WINDOW * 1e9)
    later = signer(lab, executor, now=clock[0])
    for _ in range(50):
        there.verify(KEY, b"x", later.sign(KEY, b"x"))
    assert len(there._nonces) <= 51


def test_an_emergency_stop_is_accepted_with_any_clock(lab: KeyedLab, tmp_path: Path) -> None:
    """The clocks of both sides and the certificate of the signer may be wrong."""
    lab.authority.add("old", Role.OPERATOR, tmp_path / "old", days=1e-9)
    node, long_ago, key = read_keys(lab.keys("maze")), lambda: 0, "seoro/1/default/estop"
    files = KeyFolder(tmp_path / "old")
    own, certificate = read_pair(files.key, files.certificate)  # at any time
    old = replace(read_keys(lab.keys("anna")), key=own, certificate=certificate)
    seal = sign_emergency_stop(old, key, b"x")
    there = verifier(node, clock=long_ago)
    assert there.verify_stop(key, b"x", seal).name == "old"
    with pytest.raises(UsageError, match="received before"):
        there.verify_stop(key, b"x", seal)
    for statement, payload in ((key, b"y"), ("seoro/1/default/node/maze/cmd/emergency_stop", b"x")):
        with pytest.raises(UsageError, match="invalid signature"):
            there.verify_stop(statement, payload, seal)
    with pytest.raises(UsageError):  # and the signature is invalid for other commands
        verifier(node, boot="").verify(key, b"x", seal)


def test_an_emergency_stop_by_a_revoked_signer_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    lab.authority.add("rob2", Role.OPERATOR, tmp_path / "rob2")
    lab.authority.revoke("rob2")
    node = read_keys(lab.keys("maze"))
    revoked = read_list(lab.path / "ca" / "revoked.crl", node.authority)
    seal = sign_emergency_stop(read_keys(tmp_path / "rob2"), "key", b"x")
    with pytest.raises(UsageError, match="is revoked"):
        CommandVerifier(node, BOOT, lambda: revoked).verify_stop("key", b"x", seal)


def test_a_proof_by_another_node_is_refused(lab: KeyedLab) -> None:
    made, now = CommandSigner(read_keys(lab.keys("anna")), "maze", Role.NODE), time.time_ns()
    here = (now, now)
    node, executor = read_keys(lab.keys("maze")), read_keys(lab.keys(NAME))
    proof = prove(executor, "maze", NONCE, BOOT, now, EXCHANGE)
    with pytest.raises(UsageError, match=f"it answers with the keys of {NAME}"):
        made.accept(certificate_der(executor.certificate), proof, NONCE, BOOT, now, here, EXCHANGE)
    proof = prove(node, "maze", NONCE, BOOT, now, EXCHANGE)
    made.accept(certificate_der(node.certificate), proof, NONCE, BOOT, now, here, EXCHANGE)
