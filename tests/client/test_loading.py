"""Modules that a remote command loads: most of its additional time compared to a local run."""

import subprocess
import sys

NOT_NEEDED = (
    "cryptography",  # without keys
    "numpy",
    "seoro.bridges.wire.all_messages",  # requests to simulators
    "seoro.runtime.behaviors",
    "seoro.runtime.run",
)


def test_a_remote_run_does_not_import_the_runtime() -> None:
    code = "import seoro.cli.exec_command, seoro.cli.exec_remote, sys; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert not set(NOT_NEEDED) & set(loaded)
    assert "seoro.client" in loaded
