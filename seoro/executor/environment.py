"""Environment variables of runs: those of the executor that say nothing about its user, and no others."""

from __future__ import annotations

import os
import site
from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from seoro.keys.folder import VARIABLE as KEYS
from seoro.keys.folder import chosen_folder, default_folder

PASSED: Final = (
    *("PATH", "LANG", "LANGUAGE", "LC_*", "TZ"),
    *("PYTHONPATH", "PYTHONUSERBASE", "LD_LIBRARY_PATH", "MUJOCO_GL"),  # where programs and drivers are
    *("AMENT_PREFIX_PATH", "ROS_*", "RMW_*"),  # a ROS installation, for `ros_run` and `ros_launch`
)
USER_SITE: Final = "PYTHONUSERBASE"


def passed(environment: Mapping[str, str], more: Collection[str] = ()) -> dict[str, str]:
    """The variables that runs may see.

    Args:
        environment: That of the executor.
        more: Further names, or patterns of names.
    """
    patterns = (*PASSED, *more)
    return {
        name: value
        for name, value in environment.items()
        if name != KEYS and any(fnmatchcase(name, pattern) for pattern in patterns)
    }


def for_runs(more: Collection[str], keys: Path | None) -> dict[str, str]:
    """The environment of the process that makes those of runs.

    Args:
        more: Names, or patterns of names, that a policy adds.
        keys: Folder of keys that runs use; by default the one that this process uses.
    """
    made = passed(os.environ, more)
    if site.ENABLE_USER_SITE:  # which Python finds by `HOME`, and that is another one in a run
        made[USER_SITE] = site.getuserbase()
    # Absolute, since runs have working directories of their own.
    made[KEYS] = str((keys or chosen_folder() or default_folder()).absolute())
    return made


def enter(more: Collection[str], home: Path) -> None:
    """Have this process, and those that it starts, see what one run may see.

    Args:
        more: Names, or patterns of names, that the policy adds for this run.
        home: Its home folder.
    """
    kept = passed(os.environ, more) | {name: os.environ[name] for name in (USER_SITE, KEYS) if name in os.environ}
    os.environ.clear()
    os.environ.update(kept, HOME=str(home))
