"""What a command loads that sends a scenario: that is most of what it takes longer than one that runs it here."""

import subprocess
import sys

NOT_NEEDED = (
    "cryptography",  # without keys
    "numpy",
    "seoro.bridges.wire.everything",  # what simulators are asked
    "seoro.runtime.behaviors",
    "seoro.runtime.run",
)


def test_a_command_that_sends_a_scenario_loads_nothing_of_what_runs_it() -> None:
    code = "import seoro.cli.exec_command, seoro.cli.exec_remote, sys; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert not set(NOT_NEEDED) & set(loaded)
    assert "seoro.client" in loaded
