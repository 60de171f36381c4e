"""xacro files as URDF: macros are expanded by the package xacro, in a process of its own.

Macros contain expressions, which xacro evaluates as Python without built-in functions. So the process has little
time and memory, writes nothing, and is not started for scenarios of others.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Final
from urllib.parse import parse_qsl

from seoro.deferred import dataclass

SUFFIX: Final = ".xacro"
MARK: Final = f"{SUFFIX}?"  # of a name with arguments
SWITCH: Final = "SEORO_XACRO"  # environment variable; `off` in processes that run scenarios of others
TIMEOUT: Final = 30.0  # [s]
MAX_MESSAGE: Final = 500  # [characters]


class InvalidXacro(Exception):
    """A xacro file cannot be expanded; the message has the reason, without the path."""


@dataclass(frozen=True)
class Expanded:
    """An expanded file: its URDF, and all xacro and YAML files that were read."""

    text: str
    paths: tuple[Path, ...]


def split_arguments(named: str) -> tuple[str, dict[str, str]]:
    """Split a name like `robot.urdf.xacro?arm=left&gripper=true` into that of the file, and its arguments."""
    place = named.rfind(MARK)
    if place < 0:
        return named, {}
    end = place + len(SUFFIX)
    return named[:end], dict(parse_qsl(named[end + 1 :], keep_blank_values=True))


def expand(path: Path, arguments: Mapping[str, str]) -> Expanded:
    """Expand the macros of a file.

    Args:
        path: The file.
        arguments: Values of `<xacro:arg>` by name.

    Raises:
        InvalidXacro: The file is invalid, takes too long or too much memory, or xacro is not available here.
    """
    if os.environ.get(SWITCH) == "off":
        raise InvalidXacro(f"xacro files are not expanded here ({SWITCH}=off); expand it beforehand")
    if find_spec("xacro") is None:
        raise InvalidXacro("xacro is not installed: pip install 'seoro[xacro]'")
    pairs = [f"{key}={value}" for key, value in arguments.items()]
    command = [sys.executable, "-m", "seoro.bridges.xacro_process", str(path.absolute()), *pairs]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired as error:
        raise InvalidXacro(f"expanding takes more than {TIMEOUT:g} s") from error
    if done.returncode < 0:
        raise InvalidXacro(f"expanding exceeds the limits of time or size (signal {-done.returncode})")
    if done.returncode:
        raise InvalidXacro(done.stderr.decode("utf-8", "replace").strip()[-MAX_MESSAGE:])
    text, *paths = done.stdout.decode("utf-8", "surrogateescape").split("\0")
    return Expanded(text, tuple(map(Path, paths)))
