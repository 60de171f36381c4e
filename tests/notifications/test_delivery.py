"""Delivery of notifications to a real HTTP server."""

from __future__ import annotations

import hmac
import socket
import time
from base64 import b64encode
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from seoro.errors import UsageError
from seoro.notifications.addresses import read_address
from seoro.notifications.delivery import ATTEMPTS, LONGEST, deliver
from seoro.notifications.message import Message
from tests.notifications.hooks import Hook, hooked

MESSAGE = Message("run", {"status": "passed", "reason": "x" * 10_000})


def _send(*hooks: Hook, longest: float = LONGEST) -> list[str]:
    return deliver([read_address(hook.url) for hook in hooks], MESSAGE, longest)


def test_a_message_has_format_version_and_bounded_texts() -> None:
    with hooked(Hook()) as hook:
        assert _send(hook) == []
    [found] = hook.messages
    assert (found["format"], found["version"], found["event"]) == ("seoro.notification", 1, "run")
    assert len(found["run"]["reason"]) == 4003
    [headers] = hook.headers
    assert (headers["Seoro-Event"], headers["Seoro-Delivery"]) == ("run", found["id"])
    assert "Seoro-Signature" not in headers
    assert hook.paths == ["/hook?token=hidden"]


def test_a_secret_signs_the_body(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEORO_NOTIFY_SECRET", "s3cret")
    with hooked(Hook()) as hook:
        assert _send(hook) == []
    expected = hmac.digest(b"s3cret", hook.bodies[0], "sha256").hex()
    assert hook.headers[0]["Seoro-Signature"] == f"sha256={expected}"


def test_busy_servers_get_another_attempt_with_the_same_id() -> None:
    with hooked(Hook(statuses=(503, 200))) as hook:
        assert _send(hook) == []
    first, second = hook.messages
    assert first == second


def test_refusals_and_redirects_are_final() -> None:
    with hooked(Hook(statuses=(403,))) as refusing, hooked(Hook(statuses=(302,))) as redirecting:
        first, second = _send(refusing, redirecting)
    assert first.endswith("status 403")
    assert second.endswith("status 302 (redirects are not followed)")
    assert (len(refusing.bodies), redirecting.paths) == (1, ["/hook?token=hidden"])
    assert "hidden" not in first + second


def test_every_url_is_tried_at_the_same_time_within_the_limit() -> None:
    with hooked(Hook(is_slow=True)) as slow, hooked(Hook()) as other:
        begun = time.monotonic()
        [problem] = _send(slow, other, longest=0.3)
        assert time.monotonic() - begun < LONGEST
    assert "no answer" in problem
    assert len(other.bodies) == 1


def test_nobody_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        url = f"http://127.0.0.1:{free.getsockname()[1]}/"
    [problem] = deliver([read_address(url)], MESSAGE)
    assert "refused" in problem


def test_busy_servers_are_given_up() -> None:
    with hooked(Hook(statuses=(500,))) as hook:
        [problem] = _send(hook)
    assert problem.endswith("status 500")
    assert len(hook.bodies) == ATTEMPTS


def test_credentials_are_sent_as_a_header_and_never_shown() -> None:
    with hooked(Hook(statuses=(401,))) as hook:
        url = hook.url.replace("//", "//ann:p%40ss@")
        address = read_address(url)
        [problem] = deliver([address], MESSAGE)
    assert hook.headers[0]["Authorization"] == f"Basic {b64encode(b'ann:p@ss').decode()}"
    assert not {"ann", "p@ss", "p%40ss"} & set(problem.replace(":", " ").split())
    assert "ann" not in address.shown + address.url


def test_https_needs_a_trusted_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = _certificate(tmp_path)
    with hooked(Hook(certificate=file)) as hook:
        [problem] = _send(hook)
        assert "certificate" in problem
        assert hook.bodies == []
        monkeypatch.setenv("SSL_CERT_FILE", str(file))
        assert _send(hook) == []
    assert len(hook.bodies) == 1


def _certificate(folder: Path) -> Path:
    """Write a key, and its own certificate for this machine."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "test")])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ip_address("127.0.0.1"))]), critical=False)
        .sign(key, hashes.SHA256())
    )
    file = folder / "server.pem"
    text = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    file.write_bytes(text + made.public_bytes(Encoding.PEM))
    return file


@pytest.mark.parametrize(
    ("url", "reason"),
    [
        ("http://ci.example.org/secret", "readable on the network"),
        ("http://10.0.0.1/secret", "readable on the network"),
        ("ftp://secret.example.org/", "expected https"),
        ("file:///secret", "expected https"),
        ("https://", "expected https"),
        ("https://[secret", "malformed"),
        ("https://example.org:secret/", "malformed"),
        ("https://example.org/secret\r\nX: y", "printable"),
        ("https://example.org/secret" + "x" * 3000, "at most 2000"),
        ("secret", "expected https"),
    ],
)
def test_invalid_urls_are_refused_without_being_shown(url: str, reason: str) -> None:
    with pytest.raises(UsageError, match=reason) as raised:
        read_address(url)
    assert "/secret" not in f"{raised.value.message} {raised.value.help}"


def test_plain_http_needs_permission(monkeypatch: pytest.MonkeyPatch) -> None:
    assert read_address("http://localhost:8000/").is_local
    assert read_address("http://[::1]:8000/x").shown == "http://[::1]:8000/..."
    monkeypatch.setenv("SEORO_NOTIFY_HTTP", "1")
    assert read_address("http://ci.example.org/x").shown == "http://ci.example.org/..."
