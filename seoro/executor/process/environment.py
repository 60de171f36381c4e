"""Environment variables of runs: those of the executor that contain no private data."""

from __future__ import annotations

import os
import site
from collections.abc import Collection, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Final

from seoro.bridges.xacro_files import SWITCH
from seoro.security.keys import VARIABLE as KEYS
from seoro.security.keys.folder import chosen_folder, default_folder

PASSED: Final = (
    *("PATH", "LANG", "LANGUAGE", "LC_*", "TZ"),
    *("PYTHONPATH", "PYTHONUSERBASE", "LD_LIBRARY_PATH", "MUJOCO_GL"),  # programs and drivers
    *("AMENT_PREFIX_PATH", "ROS_*", "RMW_*"),  # a ROS installation, for `ros_run` and `ros_launch`
)
USER_SITE: Final = "PYTHONUSERBASE"


def passed(environment: Mapping[str, str], more: Collection[str] = ()) -> dict[str, str]:
    """Return the variables that runs see.

    Args:
        environment: Environment of the executor.
        more: Further names, or patterns of names.
    """
    patterns = (*PASSED, *more)
    return {
        name: value
        for name, value in environment.items()
        if name != KEYS and any(fnmatchcase(name, pattern) for pattern in patterns)
    }


def for_runs(more: Collection[str], keys: Path | None) -> dict[str, str]:
    """Return the environment of the fork server.

    Args:
        more: Names, or patterns of names, that a policy adds.
        keys: Folder of keys of runs; by default that of this process.
    """
    variables = passed(os.environ, more)
    if site.ENABLE_USER_SITE:  # Python finds it by `HOME`, which differs in a run
        variables[USER_SITE] = site.getuserbase()
    # An absolute path, since runs have other working directories.
    variables[KEYS] = str((keys or chosen_folder() or default_folder()).absolute())
    return variables


def enter(more: Collection[str], home: Path) -> None:
    """Restrict the environment of this process and its children to that of a run.

    Args:
        more: Names, or patterns of names, that the policy adds for this run.
        home: Home folder of the run.
    """
    kept = passed(os.environ, more) | {name: os.environ[name] for name in (USER_SITE, KEYS) if name in os.environ}
    os.environ.clear()
    os.environ.update(kept, HOME=str(home))
    os.environ[SWITCH] = "off"  # xacro files are programs, and runs may be those of others
