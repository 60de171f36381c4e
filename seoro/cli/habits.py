"""Options of scenario_execution, for errors about unknown options of `seoro exec`."""

from __future__ import annotations

from typing import Final

OPTIONS: Final = {
    "--scenario-parameter-file": "write `--params FILE`",
    "--create-scenario-parameter-file-template": "write `--dry-run --json`, which prints the parameters",
    "--step-duration": "leave it out: behaviors wake at events, not in steps",
    "--log-model": "write `seoro check FILE`, which reports errors with their places",
    "--dot": "write `--report`, whose page shows the tree",
    "--tick-log": "write `--trace FILE`, which records the times of all behaviors",
    "--bt-log": "write `--trace FILE`, which records each change of all behaviors",
    "--post-run": "write the command after `seoro exec`, whose exit status is the verdict",
    "--snapshot-period": "leave it out: states are published when they change, at most five times per second",
    "--simulation": "write `--sim mujoco`, or `--connect` for a running simulator",
    "-l": "write `seoro check FILE`, which reports errors with their places",
    "-s": "leave it out: behaviors wake at events, not in steps",
    "-d": "write `--debug` for tracebacks, or `--trace FILE` for all steps",
}
"""Replacements by option."""
