"""Making identities, taking them back, and reading them."""

import subprocess
import sys
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import pytest
from cryptography import x509

from seoro.errors import InvalidUse
from seoro.keys import certificates
from seoro.keys.authority import init_authority, open_authority
from seoro.keys.certificates import Seat, identity_of, seat_of
from seoro.keys.folder import KeyFolder, read_keys
from seoro.keys.revocation import parse_list, read_list
from seoro.keys.roles import PEOPLE, READING, Role, executor_verbs
from tests.labs import KeyedLab, make_lab


@pytest.fixture
def lab(tmp_path: Path) -> KeyedLab:
    return make_lab(tmp_path)


def test_an_identity_is_read_as_it_was_made(lab: KeyedLab) -> None:
    identity = read_keys(lab.keys("anna")).identity
    assert (identity.lab, identity.name, identity.role) == ("demo", "anna", Role.OPERATOR)
    assert identity.ends - datetime.now(UTC) > timedelta(days=364)


def test_keys_are_for_their_holder_only(lab: KeyedLab) -> None:
    key = KeyFolder(lab.keys("anna")).key
    assert lab.keys("anna").stat().st_mode & 0o777 == 0o700
    assert key.stat().st_mode & 0o777 == 0o600
    key.chmod(0o640)
    with pytest.raises(InvalidUse, match="others can read it"):
        read_keys(lab.keys("anna"))


def test_only_those_who_listen_have_certificates_for_servers(lab: KeyedLab) -> None:
    for name, serves in {"anna": False, "lab-a": True, "maze": True, "hub": True}.items():
        uses = (
            read_keys(lab.keys(name)).certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        )
        assert (x509.oid.ExtendedKeyUsageOID.SERVER_AUTH in uses) == serves


def test_hosts_are_in_the_certificate(lab: KeyedLab) -> None:
    made = lab.authority.add("lab-b", Role.EXECUTOR, lab.keys("lab-b"), hosts=["lab-b.example.org", "10.0.0.7"])
    assert {"lab-b.example.org", "10.0.0.7", "localhost", "127.0.0.1"} <= set(made.hosts)
    renewed = lab.authority.renew("lab-b", lab.keys("lab-b"))
    assert set(renewed.hosts) == set(made.hosts)
    with pytest.raises(InvalidUse, match="nobody connects to a viewer"):
        lab.authority.add("vic", Role.VIEWER, lab.keys("vic"), hosts=["here"])


@pytest.mark.parametrize("name", ["", "Anna", "a/b", "../a", "a" * 65])
def test_names_that_keys_could_not_have_are_refused(lab: KeyedLab, name: str) -> None:
    with pytest.raises(InvalidUse, match="cannot name an identity"):
        lab.authority.add(name, Role.VIEWER, lab.keys("other"))


def test_a_name_is_given_once_and_again_when_it_was_revoked(lab: KeyedLab) -> None:
    with pytest.raises(InvalidUse, match="there is a 'anna' already"):
        lab.authority.add("anna", Role.VIEWER, lab.keys("other"))
    first = read_keys(lab.keys("anna")).identity
    lab.authority.revoke("anna")
    again = lab.authority.add("anna", Role.OPERATOR, lab.keys("anna-again"))
    assert again.seat != first.seat
    states = {(each.identity.seat, each.is_revoked) for each in lab.authority.issued()}
    assert {(first.seat, True), (again.seat, False)} <= states


def test_what_is_revoked_stays_so_for_all_renewals(lab: KeyedLab) -> None:
    old = read_keys(lab.keys("anna")).identity
    lab.authority.renew("anna", lab.keys("anna"))
    new = read_keys(lab.keys("anna")).identity
    assert (old.seat, old.serial != new.serial) == (new.seat, True)
    lab.authority.revoke("anna")
    revoked = read_list(lab.path / "ca" / "revoked.crl", read_keys(lab.keys("vera")).authority)
    assert revoked.has(old.serial)
    assert revoked.has(new.serial)
    assert not revoked.has(read_keys(lab.keys("vera")).identity.serial)
    with pytest.raises(InvalidUse, match="there is no 'anna'"):
        lab.authority.revoke("anna")


def test_a_list_of_another_lab_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    other = make_lab(tmp_path / "other")
    data = (other.path / "ca" / "revoked.crl").read_bytes()
    with pytest.raises(InvalidUse, match="not signed by the lab"):
        parse_list(data, read_keys(lab.keys("vera")).authority)
    with pytest.raises(InvalidUse, match="no list"):
        parse_list(data[:40], read_keys(lab.keys("vera")).authority)


def test_keys_that_do_not_belong_together_are_refused(lab: KeyedLab, tmp_path: Path) -> None:
    other = KeyFolder(make_lab(tmp_path / "other").keys("anna"))
    mine = KeyFolder(lab.keys("anna"))
    whole = mine.certificate.read_bytes()
    mine.certificate.write_bytes(other.certificate.read_bytes())
    with pytest.raises(InvalidUse, match="does not belong to"):
        read_keys(mine.path)
    mine.certificate.write_bytes(whole)
    mine.authority.write_bytes(other.authority.read_bytes())
    with pytest.raises(InvalidUse, match="not signed by the lab 'demo'"):
        read_keys(mine.path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("identity.crt", "nothing", "is no certificate"),
        ("identity.key", "nothing", "is no private key"),
        ("ca.crt", None, "cannot read"),
        ("identity.crt", None, "contains no keys"),
    ],
)
def test_keys_that_are_not_whole_are_refused(lab: KeyedLab, name: str, content: str | None, message: str) -> None:
    path = lab.keys("anna") / name
    path.unlink()
    if content is not None:
        path.touch(0o600)
        path.write_text(content)
    with pytest.raises(InvalidUse, match=message):
        read_keys(lab.keys("anna"))


def test_a_certificate_is_valid_for_its_time_only(lab: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    lab.authority.add("old", Role.VIEWER, lab.keys("old"), days=1e-9)
    with pytest.raises(InvalidUse, match="has expired on"):
        read_keys(lab.keys("old"))
    with monkeypatch.context() as patch:
        patch.setattr(certificates, "_EARLY", timedelta(hours=-1))
        lab.authority.add("new", Role.VIEWER, lab.keys("new"))
    with pytest.raises(InvalidUse, match="is not valid before"):
        read_keys(lab.keys("new"))


def test_keys_of_another_role_are_refused(lab: KeyedLab) -> None:
    with pytest.raises(InvalidUse, match=r"vera \(viewer\), and cannot be used as executor"):
        read_keys(lab.keys("vera"), frozenset({Role.EXECUTOR}))


def test_a_folder_with_keys_is_not_written_over(lab: KeyedLab) -> None:
    with pytest.raises(InvalidUse, match="there are keys in"):
        lab.authority.add("other", Role.VIEWER, lab.keys("anna"))
    with pytest.raises(InvalidUse, match="keys of a lab in"):
        init_authority(lab.path / "ca", "demo")
    with pytest.raises(InvalidUse, match="key of a lab is not in"):
        open_authority(lab.keys("anna"))


def test_an_identity_may_lie_beside_the_key_of_the_lab(lab: KeyedLab) -> None:
    lab.authority.add("here", Role.ADMIN, lab.path / "ca")
    assert read_keys(lab.path / "ca").identity.name == "here"


def test_a_serial_number_says_the_seat(lab: KeyedLab) -> None:
    assert seat_of(read_keys(lab.keys("vera")).identity.serial) == Seat(Role.VIEWER, 1)
    with pytest.raises(InvalidUse, match="serial number"):
        seat_of(12345)


def test_a_lab_has_so_many_seats(lab: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.keys.authority.SEATS", 1)
    with pytest.raises(InvalidUse, match="has had 1 identities with the role viewer"):
        lab.authority.add("vic", Role.VIEWER, lab.keys("vic"))


def test_the_authority_is_no_identity(lab: KeyedLab) -> None:
    with pytest.raises(InvalidUse, match="not made by `seoro keys add`"):
        identity_of(read_keys(lab.keys("vera")).authority)


def test_each_role_may_what_those_before_it_may() -> None:
    assert executor_verbs(Role.VIEWER) == READING
    for less, more in pairwise(PEOPLE):
        assert executor_verbs(less) < executor_verbs(more)
    assert executor_verbs(Role.EXECUTOR) == executor_verbs(Role.ROUTER) == frozenset()


def test_without_keys_nothing_is_loaded_for_them() -> None:
    script = (
        "import sys, seoro.client, seoro.executor.running, seoro.cli.main; print('cryptography' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout == b"False\n"


def test_the_list_has_the_names_of_executors_and_nodes(lab: KeyedLab) -> None:
    path, authority = lab.path / "ca" / "revoked.crl", read_keys(lab.keys("anna")).authority
    for number in range(2, 40):  # more than fit into a length of one byte
        lab.authority.add(f"hall-{number}", Role.NODE, lab.path / f"hall-{number}")
    lab.authority.renew("maze", lab.path / "renewed")
    names = read_list(path, authority).names
    assert names[Seat(Role.EXECUTOR, 1)] == "lab-a"
    assert (names[Seat(Role.NODE, 1)], names[Seat(Role.NODE, 39)], len(names)) == ("maze", "hall-39", 40)
    lab.authority.revoke("maze")
    assert Seat(Role.NODE, 1) not in read_list(path, authority).names
