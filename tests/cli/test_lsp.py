"""`seoro lsp`; what it serves is tested with the server."""

import importlib.util
import subprocess
import sys

import pytest

from seoro.cli import lsp_command
from seoro.cli.main import main


def test_without_pygls_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lsp_command, "find_spec", lambda _: None)
    assert importlib.util.find_spec("pygls") is not None
    assert main(["lsp"]) == 2
    assert "pip install 'seoro[lsp]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("2087", "this machine"),
        ("0.0.0.0:2087", "this machine"),
        ("localhost:port", "no address"),
        ("[::1]:0", "no address"),
    ],
)
def test_other_machines_cannot_connect(address: str, reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lsp", "--tcp", address]) == 2
    assert reason in capsys.readouterr().err


def test_what_libraries_print_does_not_get_into_the_protocol() -> None:
    code = (
        "import seoro.lsp.server as s, seoro.cli.main as m;"
        "s.SeoroServer.start_io = lambda self, i, o: (print('stray'), o.write(b'kept'));"
        "m.main(['lsp'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, timeout=60)
    assert (done.stdout, done.stderr) == (b"kept", b"stray\n")
