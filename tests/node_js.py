"""Node.js, which builds pages and the extension for VS Code, in tests."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

NODE = 20  # oldest major version


def has_node() -> bool:
    """Return whether a version of Node.js is installed that is new enough."""
    node = shutil.which("node")
    if node is None:
        return False
    version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True).stdout
    return int(version.removeprefix("v").partition(".")[0]) >= NODE


# Codes of npm where the registry is not reachable, or does not have a package.
_UNREACHABLE = (
    "ENOTFOUND",
    "ECONN",
    "ETIMEDOUT",
    "EAI_AGAIN",
    "ERR_SOCKET",
    "E401",
    "E403",
    "E404",
    "E500",
    "E502",
    "E503",
)

needs_node = pytest.mark.skipif(not has_node(), reason=f"needs Node.js {NODE}")


def copy_source(folder: Path, target: Path) -> Path:
    """Copy a package without installed and built files; returns the copy."""
    return Path(shutil.copytree(folder, target, ignore=shutil.ignore_patterns("node_modules", "dist")))


def npm(folder: Path, *arguments: str) -> None:
    """Run npm in a folder. A test without a reachable registry is skipped."""
    command = ["npm", *arguments, "--no-audit", "--no-fund", "--fetch-retries=1", "--fetch-timeout=30000"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=240, check=False)
    if done.returncode != 0 and any(f"code {code}" in done.stderr for code in _UNREACHABLE):
        pytest.skip("the registry of npm is not reachable, or lacks a package")
    assert done.returncode == 0, done.stdout + done.stderr
