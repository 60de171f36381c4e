"""`scenario-execution`, with which others are compared: an environment for it, and its command."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import venv
from pathlib import Path

PEER = "scenario-execution==1.8.0"

_STAMP = re.compile(r"\[INFO\] \[(\d+\.\d+)\] \[scenario_execution\]: (.*)")


def add_peer_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options that select the peer."""
    parser.add_argument("--peer", metavar="PYTHON", help="interpreter of an environment with scenario-execution")
    parser.add_argument("--install-peer", action="store_true", help=f"make an environment with {PEER}")


def peer_of(options: argparse.Namespace) -> str | None:
    """The interpreter that the options ask for; None if the peer is not to be measured."""
    return installed_peer() if options.install_peer else options.peer


def installed_peer() -> str:
    """The interpreter of an environment with the peer, which is made unless there is one."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = cache / "seoro" / "benchmarks" / PEER
    python = folder / "bin" / "python"
    if not (folder / "complete").exists():
        venv.create(folder, with_pip=True, clear=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", PEER], check=True)
        (folder / "complete").touch()
    return str(python)


def command(python: str) -> list[str]:
    """Its command line."""
    return [str(Path(python).with_name("scenario_execution"))]


def stamps(python: str, scenario: Path, timeout: float = 600.0) -> list[tuple[float, str]]:
    """Run the peer; return its log messages with times [s], or nothing if it fails."""
    done = subprocess.run(
        [*command(python), str(scenario)], check=False, capture_output=True, text=True, timeout=timeout
    )
    if done.returncode != 0:
        return []
    return [(float(time), text) for time, text in _STAMP.findall(done.stdout + done.stderr)]
