"""Seals: who has said something, whatever has carried it."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.errors import InvalidUse
from seoro.keys.files import read_pair
from seoro.keys.folder import KeyFolder, Keys, read_keys
from seoro.keys.revocation import Revocations, read_list
from seoro.keys.roles import Role
from seoro.keys.sealing import WINDOW, Sealer, Stale, Verifier, prove, seal_urgently
from seoro.keys.signing import certificate_der
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


def verifier(keys: Keys, clock: Callable[[], int] = time.time_ns, boot: str = BOOT) -> Verifier:
    return Verifier(keys, boot, lambda: Revocations(0), clock)


def sealer(lab: KeyedLab, executor: Keys, name: str = "anna", now: int | None = None, boot: str = BOOT) -> Sealer:
    made = Sealer(read_keys(lab.keys(name)), NAME)
    stamp = time.time_ns() if now is None else now
    proof = prove(executor, NAME, NONCE, boot, stamp, EXCHANGE)
    here = time.time_ns()
    made.accept(certificate_der(executor.certificate), proof, NONCE, boot, stamp, (here, here), EXCHANGE)
    return made


def test_a_seal_says_who_has_sealed(lab: KeyedLab, executor: Keys) -> None:
    assert verifier(executor).verify(KEY, b"x", sealer(lab, executor).seal(KEY, b"x")).name == "anna"


def test_what_is_said_twice_is_refused_the_second_time(lab: KeyedLab, executor: Keys) -> None:
    there, seal = verifier(executor), sealer(lab, executor).seal(KEY, b"x")
    there.verify(KEY, b"x", seal)
    with pytest.raises(InvalidUse, match="said before"):
        there.verify(KEY, b"x", seal)


def test_a_seal_is_for_one_command_to_one_executor_only(lab: KeyedLab, executor: Keys) -> None:
    there, seal = verifier(executor), sealer(lab, executor).seal(KEY, b"x")
    other = "seoro/1/default/exec/lab-b/cmd/submit"
    for key, payload in ((KEY, b"y"), (KEY.replace("submit", "stop_run"), b"x"), (other, b"x")):
        with pytest.raises(InvalidUse, match="signature is wrong"):
            there.verify(key, payload, seal)


def test_a_seal_is_for_one_start_of_the_executor_only(lab: KeyedLab, executor: Keys) -> None:
    seal = sealer(lab, executor).seal(KEY, b"x")
    with pytest.raises(Stale, match="another start"):
        verifier(executor, boot="an0ther").verify(KEY, b"x", seal)


def test_a_seal_lasts_for_a_while_only(lab: KeyedLab, executor: Keys) -> None:
    seal = sealer(lab, executor).seal(KEY, b"x")
    later = time.time_ns() + int((WINDOW + 1.0) * 1e9)
    with pytest.raises(Stale, match="the time of the command"):
        verifier(executor, clock=lambda: later).verify(KEY, b"x", seal)


def test_clocks_may_differ(lab: KeyedLab, executor: Keys) -> None:
    ahead = 3600 * 10**9
    made = sealer(lab, executor, now=time.time_ns() + ahead)
    there = verifier(executor, clock=lambda: time.time_ns() + ahead)
    assert there.verify(KEY, b"x", made.seal(KEY, b"x")).name == "anna"


def test_somebody_revoked_is_refused(lab: KeyedLab, executor: Keys, tmp_path: Path) -> None:
    lab.authority.add("rob", read_keys(lab.keys("anna")).identity.role, tmp_path / "rob")
    lab.authority.revoke("rob")
    revoked = read_list(lab.path / "ca" / "revoked.crl", executor.authority)
    made = Sealer(read_keys(tmp_path / "rob"), NAME)
    there = Verifier(executor, BOOT, lambda: revoked)
    with pytest.raises(InvalidUse, match=r"rob \(operator\) is revoked"):
        there.verify(KEY, b"x", made.seal(KEY, b"x"))


def test_somebody_of_another_lab_is_refused(lab: KeyedLab, executor: Keys, tmp_path: Path) -> None:
    other = make_lab(tmp_path)
    seal = Sealer(read_keys(other.keys("ada")), NAME).seal(KEY, b"x")
    with pytest.raises(InvalidUse, match="not signed by the lab"):
        verifier(executor).verify(KEY, b"x", seal)


@pytest.mark.parametrize("seal", [b"", b"\xc1", b"x", b"\x95\x01\x02\x03\x04\x05", bytes(10_000)])
def test_what_is_no_seal_is_refused(executor: Keys, seal: bytes) -> None:
    with pytest.raises(InvalidUse, match=r"keys only|is no seal"):
        verifier(executor).verify(KEY, b"x", seal)


def test_only_the_executor_of_a_name_answers_for_it(lab: KeyedLab) -> None:
    made = Sealer(read_keys(lab.keys("anna")), NAME)
    now = time.time_ns()
    for name in ("maze", "ada"):
        other = read_keys(lab.keys(name))
        proof = prove(other, NAME, NONCE, BOOT, now, EXCHANGE)
        with pytest.raises(InvalidUse, match=f"who answers for the executor '{NAME}' has the keys of {name}"):
            made.accept(certificate_der(other.certificate), proof, NONCE, BOOT, now, (now, now), EXCHANGE)


def test_an_old_proof_is_refused(lab: KeyedLab, executor: Keys) -> None:
    made, now = Sealer(read_keys(lab.keys("anna")), NAME), time.time_ns()
    proof = prove(executor, NAME, NONCE, BOOT, now, EXCHANGE)
    with pytest.raises(InvalidUse, match="signature is wrong"):
        made.accept(certificate_der(executor.certificate), proof, b"1" * 16, BOOT, now, (now, now), EXCHANGE)


def test_a_clock_that_is_set_back_lets_no_command_be_said_again(lab: KeyedLab, executor: Keys) -> None:
    """Also when its number was forgotten meanwhile."""
    clock, made = [time.time_ns()], sealer(lab, executor)
    there, old = verifier(executor, clock=lambda: clock[0]), made.seal(KEY, b"x")
    there.verify(KEY, b"x", old)
    began, later = clock[0], clock[0] + int((2.0 * WINDOW + 1.0) * 1e9)
    clock[0] = later
    for _ in range(3):
        there.verify(KEY, b"x", sealer(lab, executor, now=later).seal(KEY, b"x"))
    clock[0] = began
    with pytest.raises(InvalidUse, match=r"said before|the time of the command"):
        there.verify(KEY, b"x", old)


def test_the_time_of_day_does_not_count_for_commands(
    lab: KeyedLab, executor: Keys, monkeypatch: pytest.MonkeyPatch
) -> None:
    there, seal = Verifier(executor, BOOT, lambda: Revocations(0)), sealer(lab, executor).seal(KEY, b"x")
    there.verify(KEY, b"x", seal)
    now = time.time_ns()
    monkeypatch.setattr("time.time_ns", lambda: now - 3600 * 10**9)
    with pytest.raises(InvalidUse, match="said before"):
        there.verify(KEY, b"x", seal)


def test_what_was_said_is_not_remembered_for_ever(lab: KeyedLab, executor: Keys) -> None:
    clock, made = [time.time_ns()], sealer(lab, executor)
    there = verifier(executor, clock=lambda: clock[0])
    for _ in range(50):
        there.verify(KEY, b"x", made.seal(KEY, b"x"))
    clock[0] += int(2.5 * WINDOW * 1e9)
    later = sealer(lab, executor, now=clock[0])
    for _ in range(50):
        there.verify(KEY, b"x", later.seal(KEY, b"x"))
    assert len(there._nonces) <= 51


def test_an_emergency_stop_is_taken_whatever_time_it_is(lab: KeyedLab, tmp_path: Path) -> None:
    """Here, there, and by the certificate of who stops."""
    lab.authority.add("old", Role.OPERATOR, tmp_path / "old", days=1e-9)
    node, long_ago, key = read_keys(lab.keys("maze")), lambda: 0, "seoro/1/default/estop"
    files = KeyFolder(tmp_path / "old")
    own, certificate = read_pair(files.key, files.certificate)  # whatever time it is
    old = replace(read_keys(lab.keys("anna")), key=own, certificate=certificate)
    seal = seal_urgently(old, key, b"x")
    there = verifier(node, clock=long_ago)
    assert there.verify_urgent(key, b"x", seal).name == "old"
    with pytest.raises(InvalidUse, match="said before"):
        there.verify_urgent(key, b"x", seal)
    for said, payload in ((key, b"y"), ("seoro/1/default/node/maze/cmd/emergency_stop", b"x")):
        with pytest.raises(InvalidUse, match="signature is wrong"):
            there.verify_urgent(said, payload, seal)
    with pytest.raises(InvalidUse):  # and it is no seal for anything else
        verifier(node, boot="").verify(key, b"x", seal)


def test_an_emergency_stop_by_somebody_revoked_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    lab.authority.add("rob2", Role.OPERATOR, tmp_path / "rob2")
    lab.authority.revoke("rob2")
    node = read_keys(lab.keys("maze"))
    revoked = read_list(lab.path / "ca" / "revoked.crl", node.authority)
    seal = seal_urgently(read_keys(tmp_path / "rob2"), "key", b"x")
    with pytest.raises(InvalidUse, match="is revoked"):
        Verifier(node, BOOT, lambda: revoked).verify_urgent("key", b"x", seal)


def test_only_the_node_of_a_name_answers_for_it(lab: KeyedLab) -> None:
    made, now = Sealer(read_keys(lab.keys("anna")), "maze", Role.NODE), time.time_ns()
    here = (now, now)
    node, executor = read_keys(lab.keys("maze")), read_keys(lab.keys(NAME))
    proof = prove(executor, "maze", NONCE, BOOT, now, EXCHANGE)
    with pytest.raises(InvalidUse, match=f"who answers for the node 'maze' has the keys of {NAME}"):
        made.accept(certificate_der(executor.certificate), proof, NONCE, BOOT, now, here, EXCHANGE)
    proof = prove(node, "maze", NONCE, BOOT, now, EXCHANGE)
    made.accept(certificate_der(node.certificate), proof, NONCE, BOOT, now, here, EXCHANGE)
