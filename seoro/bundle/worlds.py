"""The files of worlds. Their form is a matter of simulators: a process of theirs says what a world names."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Final

from seoro.errors import InvalidUse

TIMEOUT: Final = 60.0  # [s]
SUFFIXES: Final = frozenset({".yaml", ".yml"})


def is_world_file(world: str) -> bool:
    """Whether a world is named by its file, and not by a name that simulators know."""
    return Path(world).suffix in SUFFIXES


def files_of_world(world: str) -> list[Path]:
    """A world file with all that it names.

    Raises:
        InvalidUse: One of them is not there, or is wrong, as a run here would say it; or there is no simulator
            here that could tell.
    """
    command = [sys.executable, "-m", "sim_nodes.worlds.files", world]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired as error:
        raise InvalidUse(f"the world {world} was not read within {TIMEOUT:g} s") from error
    if done.returncode == 0:
        return [Path(file) for file in json.loads(done.stdout)]
    if "ModuleNotFoundError" in done.stderr:
        raise InvalidUse(
            "which files a world names is known to simulators only, and what these need is not installed here",
            help="pip install 'seoro[node]'; or name a world that the executor's simulators have, such as `maze`",
        )
    raise InvalidUse(done.stderr.strip() or f"the world {world} cannot be read")
