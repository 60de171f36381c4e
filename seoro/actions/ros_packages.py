"""The methods of the struct `ament` in `osc.ros`: where packages of ROS 2 are installed.

The index of packages is a folder of marker files in each place where ROS 2 packages are installed, and the
variable `AMENT_PREFIX_PATH` lists those places (the ament resource index, REP 124); neither needs ROS itself.
"""

from __future__ import annotations

import os
from pathlib import Path

from seoro.errors import InvalidUse

_INDEX = Path("share/ament_index/resource_index/packages")


def get_package_share_directory(package_name: str) -> str:
    """The folder with the data of a package.

    Raises:
        InvalidUse: There is no ROS 2 environment, or the package is not in it.
    """
    places = [Path(place) for place in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if place]
    if not places:
        raise InvalidUse(
            "there is no ROS 2 here: `AMENT_PREFIX_PATH` is not set; source the `setup.bash` of ROS 2"
        )
    if not package_name or Path(package_name).name != package_name:
        raise InvalidUse(f"'{package_name}' is no name of a package")
    for place in places:
        if (place / _INDEX / package_name).is_file():
            return str(place / "share" / package_name)
    looked = ", ".join(map(str, places))
    raise InvalidUse(f"there is no ROS 2 package '{package_name}' in {looked}")
