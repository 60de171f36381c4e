"""Methods of the struct `ament` in `osc.ros`: installation folders of ROS 2 packages.

Each prefix in `AMENT_PREFIX_PATH` has a folder of marker files, one per package (the ament resource index, REP
124); reading it does not need ROS.
"""

from __future__ import annotations

import os
from pathlib import Path

from seoro.errors import UsageError

_INDEX = Path("share/ament_index/resource_index/packages")


def get_package_share_directory(package_name: str) -> str:
    """Return the share folder of a package.

    Raises:
        UsageError: ROS 2 or the package is not installed.
    """
    places = [Path(place) for place in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if place]
    if not places:
        raise UsageError("ROS 2 not found: `AMENT_PREFIX_PATH` is not set; source the `setup.bash` of ROS 2")
    if not package_name or Path(package_name).name != package_name:
        raise UsageError(f"invalid package name '{package_name}'")
    for place in places:
        if (place / _INDEX / package_name).is_file():
            return str(place / "share" / package_name)
    looked = ", ".join(map(str, places))
    raise UsageError(f"unknown ROS 2 package '{package_name}'; searched in {looked}")
