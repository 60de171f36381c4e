"""Creation, revocation and reading of identities."""

import subprocess
import sys
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import pytest
from cryptography import x509

from seoro.errors import UsageError
from seoro.security.keys import certificates
from seoro.security.keys.authority import init_authority, open_authority
from seoro.security.keys.certificates import CertificateSlot, identity_of, slot_of
from seoro.security.keys.folder import KeyFolder, read_keys
from seoro.security.keys.revocation import parse_list, read_list
from seoro.security.keys.roles import PEOPLE, Role
from tests.labs import KeyedLab, make_lab


@pytest.fixture
def lab(tmp_path: Path) -> KeyedLab:
    return make_lab(tmp_path)


def test_a_created_identity_is_read_back(lab: KeyedLab) -> None:
    identity = read_keys(lab.keys("anna")).identity
    assert (identity.lab, identity.name, identity.role) == ("demo", "anna", Role.OPERATOR)
    assert identity.ends - datetime.now(UTC) > timedelta(days=364)


def test_keys_readable_by_others_are_refused(lab: KeyedLab) -> None:
    key = KeyFolder(lab.keys("anna")).key
    assert lab.keys("anna").stat().st_mode & 0o777 == 0o700
    assert key.stat().st_mode & 0o777 == 0o600
    key.chmod(0o640)
    with pytest.raises(UsageError, match="other users can read the private key"):
        read_keys(lab.keys("anna"))


def test_only_listening_roles_have_server_certificates(lab: KeyedLab) -> None:
    for name, serves in {"anna": False, "lab-a": True, "maze": True, "hub": True}.items():
        uses = (
            read_keys(lab.keys(name)).certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        )
        assert (x509.oid.ExtendedKeyUsageOID.SERVER_AUTH in uses) == serves


def test_the_certificate_contains_the_hosts(lab: KeyedLab) -> None:
    made = lab.authority.add("lab-b", Role.EXECUTOR, lab.keys("lab-b"), hosts=["lab-b.example.org", "10.0.0.7"])
    assert {"lab-b.example.org", "10.0.0.7", "localhost", "127.0.0.1"} <= set(made.hosts)
    renewed = lab.authority.renew("lab-b", lab.keys("lab-b"))
    assert set(renewed.hosts) == set(made.hosts)
    assert lab.authority.add("cleo", Role.OPERATOR, lab.keys("cleo")).hosts == ()


def test_keys_of_people_pose_as_no_machine(lab: KeyedLab) -> None:
    with pytest.raises(UsageError, match=r"'lab-pc.example.org' of the role viewer: people do not listen"):
        lab.authority.add("vic", Role.VIEWER, lab.keys("vic"), hosts=["lab-pc.example.org"])
    with pytest.raises(UsageError, match="people do not listen"):
        lab.authority.renew("anna", lab.keys("anna"), hosts=["lab-pc.example.org"])
    assert read_keys(lab.keys("anna")).identity.hosts == ()


def test_a_site_is_no_client(lab: KeyedLab) -> None:
    lab.authority.add("lab-pc", Role.SITE, lab.keys("lab-pc"), hosts=["lab-pc.example.org"])
    extensions = read_keys(lab.keys("lab-pc")).certificate.extensions
    uses = extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
    assert list(uses) == [x509.oid.ExtendedKeyUsageOID.SERVER_AUTH]


@pytest.mark.parametrize("name", ["", "Anna", "a/b", "../a", "a" * 65])
def test_invalid_names_of_identities_are_refused(lab: KeyedLab, name: str) -> None:
    with pytest.raises(UsageError, match="of an identity"):
        lab.authority.add(name, Role.VIEWER, lab.keys("other"))


def test_a_name_is_reusable_after_its_revocation_only(lab: KeyedLab) -> None:
    with pytest.raises(UsageError, match="duplicate identity 'anna'"):
        lab.authority.add("anna", Role.VIEWER, lab.keys("other"))
    first = read_keys(lab.keys("anna")).identity
    lab.authority.revoke("anna")
    again = lab.authority.add("anna", Role.OPERATOR, lab.keys("anna-again"))
    assert again.slot != first.slot
    states = {(each.identity.slot, each.is_revoked) for each in lab.authority.issued()}
    assert {(first.slot, True), (again.slot, False)} <= states


def test_revoking_an_identity_revokes_all_renewals(lab: KeyedLab) -> None:
    old = read_keys(lab.keys("anna")).identity
    lab.authority.renew("anna", lab.keys("anna"))
    new = read_keys(lab.keys("anna")).identity
    assert (old.slot, old.serial != new.serial) == (new.slot, True)
    lab.authority.revoke("anna")
    revoked = read_list(lab.path / "ca" / "revoked.crl", read_keys(lab.keys("vera")).authority)
    assert revoked.contains(old.serial)
    assert revoked.contains(new.serial)
    assert not revoked.contains(read_keys(lab.keys("vera")).identity.serial)
    with pytest.raises(UsageError, match="unknown identity 'anna'"):
        lab.authority.revoke("anna")


def test_a_revocation_list_of_another_lab_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    other = make_lab(tmp_path / "other")
    data = (other.path / "ca" / "revoked.crl").read_bytes()
    with pytest.raises(UsageError, match="not signed by the lab"):
        parse_list(data, read_keys(lab.keys("vera")).authority)
    with pytest.raises(UsageError, match="invalid list"):
        parse_list(data[:40], read_keys(lab.keys("vera")).authority)


def test_mismatched_key_files_are_refused(lab: KeyedLab, tmp_path: Path) -> None:
    other = KeyFolder(make_lab(tmp_path / "other").keys("anna"))
    mine = KeyFolder(lab.keys("anna"))
    whole = mine.certificate.read_bytes()
    mine.certificate.write_bytes(other.certificate.read_bytes())
    with pytest.raises(UsageError, match="does not match"):
        read_keys(mine.path)
    mine.certificate.write_bytes(whole)
    mine.authority.write_bytes(other.authority.read_bytes())
    with pytest.raises(UsageError, match="not signed by the lab 'demo'"):
        read_keys(mine.path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("identity.crt", "nothing", "invalid certificate"),
        ("identity.key", "nothing", "invalid private key"),
        ("ca.crt", None, "cannot read"),
        ("identity.crt", None, "contains no keys"),
    ],
)
def test_incomplete_keys_are_refused(lab: KeyedLab, name: str, content: str | None, message: str) -> None:
    path = lab.keys("anna") / name
    path.unlink()
    if content is not None:
        path.touch(0o600)
        path.write_text(content)
    with pytest.raises(UsageError, match=message):
        read_keys(lab.keys("anna"))


def test_certificates_outside_of_their_validity_are_refused(
    lab: KeyedLab, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab.authority.add("old", Role.VIEWER, lab.keys("old"), days=1e-9)
    with pytest.raises(UsageError, match="expired on"):
        read_keys(lab.keys("old"))
    with monkeypatch.context() as patch:
        patch.setattr(certificates, "_EARLY", timedelta(hours=-1))
        lab.authority.add("new", Role.VIEWER, lab.keys("new"))
    with pytest.raises(UsageError, match="is not valid before"):
        read_keys(lab.keys("new"))


def test_keys_of_another_role_are_refused(lab: KeyedLab) -> None:
    with pytest.raises(UsageError, match=r"vera \(viewer\); expected role: executor"):
        read_keys(lab.keys("vera"), frozenset({Role.EXECUTOR}))


def test_a_folder_with_keys_is_not_overwritten(lab: KeyedLab) -> None:
    with pytest.raises(UsageError, match="already contains keys"):
        lab.authority.add("other", Role.VIEWER, lab.keys("anna"))
    with pytest.raises(UsageError, match="already contains lab keys"):
        init_authority(lab.path / "ca", "demo")
    with pytest.raises(UsageError, match="missing lab key in"):
        open_authority(lab.keys("anna"))


def test_an_identity_may_be_in_the_folder_of_the_lab_key(lab: KeyedLab) -> None:
    lab.authority.add("here", Role.ADMIN, lab.path / "ca")
    assert read_keys(lab.path / "ca").identity.name == "here"


def test_a_serial_number_contains_the_slot(lab: KeyedLab) -> None:
    assert slot_of(read_keys(lab.keys("vera")).identity.serial) == CertificateSlot(Role.VIEWER, 1)
    with pytest.raises(UsageError, match="serial number"):
        slot_of(12345)


def test_the_number_of_slots_of_a_role_is_limited(lab: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.security.keys.authority.SLOTS", 1)
    with pytest.raises(UsageError, match="no certificate slot left for role viewer"):
        lab.authority.add("vic", Role.VIEWER, lab.keys("vic"))


def test_the_certificate_of_the_authority_is_refused_as_an_identity(lab: KeyedLab) -> None:
    with pytest.raises(UsageError, match="not made by `seoro keys add`"):
        identity_of(read_keys(lab.keys("vera")).authority)


def test_each_role_includes_the_lower_roles() -> None:
    for less, more in pairwise(PEOPLE):
        assert more.includes(less)
        assert not less.includes(more)
    assert not any(role.includes(other) for role in (Role.EXECUTOR, Role.ROUTER, Role.SITE) for other in PEOPLE)


def test_cryptography_is_not_imported_without_keys() -> None:
    script = (
        "import sys, seoro.client, seoro.executor.service, seoro.cli.main; print('cryptography' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout == b"False\n"


def test_the_revocation_list_contains_names_of_executors_and_nodes(lab: KeyedLab) -> None:
    path, authority = lab.path / "ca" / "revoked.crl", read_keys(lab.keys("anna")).authority
    for number in range(2, 40):  # more than fit into a length of one byte
        lab.authority.add(f"hall-{number}", Role.NODE, lab.path / f"hall-{number}")
    lab.authority.renew("maze", lab.path / "renewed")
    names = read_list(path, authority).names
    assert names[CertificateSlot(Role.EXECUTOR, 1)] == "lab-a"
    assert (names[CertificateSlot(Role.NODE, 1)], names[CertificateSlot(Role.NODE, 39)], len(names)) == (
        "maze",
        "hall-39",
        40,
    )
    lab.authority.revoke("maze")
    assert CertificateSlot(Role.NODE, 1) not in read_list(path, authority).names
