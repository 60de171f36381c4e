"""`seoro keys`: what people see of it."""

import json
import shutil
from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.executors import HELLO
from tests.labs import NAME, keyed_executor, make_lab


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("SEORO_KEYS", "")
    return tmp_path / "config" / "seoro" / "keys"


def test_a_lab_gets_its_keys(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "init", "lab"]) == 0
    assert main(["keys", "add", "lab-a", "--role", "executor", "--host", "lab-a.example.org"]) == 0
    assert main(["keys", "add", "anna", "--role", "operator", "-o", "for-anna"]) == 0
    assert main(["keys", "renew", "anna", "-o", "for-anna"]) == 0
    assert main(["keys", "revoke", "anna"]) == 0
    assert f"copy {home / 'revoked.crl'}" in capsys.readouterr().out
    assert main(["keys", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "lab 'lab'"
    assert [line.split()[0] for line in lines[2:]] == ["anna", "anna", "lab-a"]
    assert "revoked" in lines[2]
    assert "lab-a.example.org" in lines[4]
    assert main(["keys", "list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    states = [(each["name"], each["state"]) for each in found["identities"]]
    assert states == [("anna", "revoked"), ("anna", "revoked"), ("lab-a", "valid")]
    assert "lab-a.example.org" in found["identities"][2]["hosts"]
    assert {path.name for path in Path("for-anna").iterdir()} == {
        "ca.crt", "identity.crt", "identity.key", "revoked.crl"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["list"], "missing lab key in"),
        (["init", "My Lab"], "invalid name 'My Lab' of a lab"),
        (["audit", "audit.jsonl"], "cannot read"),
        (["publish", "--executor", "tls/127.0.0.1:1"], "contains no keys"),
        (["publish", "--executor", "tls/127.0.0.1:1", "--keys", "nowhere"], "contains no keys"),
    ],
)
def test_invalid_arguments_are_rejected(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["keys", *arguments]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.more
def test_an_admin_publishes_revocations_to_an_executor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    with keyed_executor(tmp_path, lab) as there:
        monkeypatch.setenv("SEORO_EXECUTOR", there.endpoint)
        on = ["exec", str(file), "--on", NAME, "--keys"]
        assert main([*on, str(lab.keys("anna"))]) == 0
        lab.authority.revoke("anna")
        revoked = ["--revoked", str(tmp_path / "lab" / "ca" / "revoked.crl")]
        assert main(["keys", "publish", "--keys", str(lab.keys("vera")), *revoked]) == 3
        assert "may not send `revoke` (required role: admin)" in capsys.readouterr().err
        assert main(["keys", "publish", "--keys", str(lab.keys("ada")), *revoked]) == 0
        assert f"sent the revocation list to {NAME}" in capsys.readouterr().out
        errors = "nothing answers"
        while "nothing answers" in errors:  # the executor opens its endpoint anew
            assert main([*on, str(lab.keys("anna"))]) == 2
            errors = capsys.readouterr().err
        assert "clients with revoked keys see no executors" in errors
        log = str(tmp_path / "state" / "audit.jsonl")
        assert main(["keys", "audit", log, "--keys", str(lab.keys("vera"))]) == 0
        assert f"lines, signed by {NAME}" in capsys.readouterr().out
        text = Path(log).read_text()
        Path(log).write_text(text.replace('"anna"', '"vera"'))
        assert main(["keys", "audit", log, "--keys", str(lab.keys("vera"))]) == 2
        assert "audit.jsonl:2: invalid signature: the line was changed" in capsys.readouterr().err
    shutil.rmtree(tmp_path / "lab")
