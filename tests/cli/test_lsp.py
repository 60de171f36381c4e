"""`seoro lsp`: the command; tests of the server are in `tests/lsp`."""

import subprocess
import sys

import pytest

from seoro.cli.main import main


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("2087", "not a loopback address"),
        ("0.0.0.0:2087", "not a loopback address"),
        ("localhost:port", "invalid address"),
        ("[::1]:0", "invalid address"),
    ],
)
def test_other_machines_cannot_connect(address: str, reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lsp", "--tcp", address]) == 2
    assert reason in capsys.readouterr().err


def test_prints_of_libraries_stay_out_of_the_protocol() -> None:
    code = (
        "import seoro.lsp.server as s, seoro.cli.main as m;"
        "s.SeoroServer.start_io = lambda self, i, o: (print('stray'), o.write(b'kept'));"
        "m.main(['lsp'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, timeout=60)
    assert (done.stdout, done.stderr) == (b"kept", b"stray\n")
