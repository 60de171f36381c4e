"""A site that other machines reach: TLS, and the rights of a person."""

from __future__ import annotations

import ssl
from pathlib import Path

import httpx
import pytest

from seoro.errors import UsageError
from seoro.security.keys.roles import Role
from seoro.ui.listening import Address, listening, parse_address
from seoro.ui.rights import Rights
from seoro.ui.server import SiteOptions
from tests.labs import KeyedLab, make_lab
from tests.ui.conftest import serving

HOST = "127.0.0.2"  # of this machine, in the place of another one


@pytest.fixture
def lab_keys(tmp_path: Path) -> KeyedLab:
    return make_lab(tmp_path)


@pytest.fixture
def as_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Address, "is_local", False)


def certificate_for(lab: KeyedLab, host: str) -> Path:
    """Return keys of a site at a host."""
    lab.authority.add("lab-pc", Role.SITE, lab.keys("lab-pc"), hosts=[host])
    return lab.keys("lab-pc")


@pytest.mark.usefixtures("as_elsewhere")
def test_others_reach_a_site_by_tls(lab_keys: KeyedLab, tmp_path: Path) -> None:
    keys = certificate_for(lab_keys, HOST)
    unused = f"unixsock-stream/{tmp_path}/nobody"
    person = lab_keys.keys("vera")
    options = SiteOptions(
        (tmp_path,), tmp_path / "state", unused, person, Address(HOST), is_demo=False, certificate=keys
    )
    with serving(options) as served:
        assert served.access.url.startswith(f"https://{HOST}:")
        context = ssl.create_default_context(cafile=str(keys / "ca.crt"))
        with httpx.Client(base_url=served.access.url.partition("/?")[0], verify=context) as client:
            assert client.get("/").status_code == 401
            found = client.get(served.access.url)
            assert found.status_code == 303
            assert "Secure" in found.headers["set-cookie"]
            assert client.get("/api/site").status_code == 200
            plain = {"Origin": f"http://{HOST}:{served.access.port}"}
            assert client.get("/api/site", headers=plain).status_code == 403
            own = {"Origin": f"https://{HOST}:{served.access.port}"}
            for path in ("/api/start", "/api/run/x/stop", "/api/lab/stop-all"):
                refused = client.post(path, json={}, headers=own)
                assert (refused.status_code, refused.json()["error"]) == (
                    403,
                    "the keys of this site may watch only (role viewer)",
                )


def test_rights_are_those_of_roles() -> None:
    assert Rights.of(None) == Rights(may_act=True, is_owner=True)
    assert Rights.of(Role.VIEWER) == Rights(may_act=False, is_owner=False)
    assert Rights.of(Role.OPERATOR) == Rights.of(Role.ADMIN) == Rights(may_act=True, is_owner=False)


@pytest.mark.usefixtures("as_elsewhere")
def test_keys_are_needed_beyond_this_machine(lab_keys: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SEORO_KEYS", raising=False)
    with pytest.raises(UsageError, match="outside this machine"), listening(Address(HOST), None, None):
        pass
    anna, elsewhere = lab_keys.keys("anna"), certificate_for(lab_keys, "192.0.2.7")
    with pytest.raises(UsageError, match="is not for the host"), listening(Address(HOST), elsewhere, anna):
        pass
    with pytest.raises(UsageError, match="expected role: site"), listening(Address(HOST), anna, anna):
        pass
    here = lab_keys.keys("here")
    lab_keys.authority.add("here", Role.SITE, here, hosts=[HOST])
    with pytest.raises(UsageError, match="expected role: admin or operator"), listening(Address(HOST), here, here):
        pass


def test_addresses_are_parsed() -> None:
    assert parse_address("lab-pc:80") == Address("lab-pc", 80)
    assert parse_address("[::1]:0") == Address("::1", 0)
    assert Address("::1").is_local
    assert not Address("lab-pc").is_local
    for text in ("lab-pc", ":80", "lab-pc:", "lab-pc:x", "lab-pc:70000", "0.0.0.0:80", "[::]:80"):
        with pytest.raises(UsageError, match="invalid"):
            parse_address(text)


def test_foreign_addresses_are_one_error(lab_keys: KeyedLab) -> None:
    foreign = "192.0.2.7"
    keys = certificate_for(lab_keys, foreign)
    with (
        pytest.raises(UsageError, match="cannot listen"),
        listening(Address(foreign), keys, lab_keys.keys("anna")),
    ):
        pass
