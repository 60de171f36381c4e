"""Tool that packs folders of packages into the files in `data`.

To add or update a ROS 2 distribution, run

    python -m seoro.bridges.ros2.interfaces.packing DISTRIBUTION FOLDER [PACKAGE...]

FOLDER contains `PACKAGE/msg/X.msg` and so on, like `share` of an installation. Comments are removed; types, names,
constants, defaults and bounds are kept.
"""

from __future__ import annotations

import sys
from pathlib import Path

from seoro.bridges.ros2.interfaces.names import PARTS
from seoro.bridges.ros2.interfaces.packages import DATA, packages_in
from seoro.bridges.ros2.interfaces.registry import Registry
from seoro.bridges.ros2.interfaces.text import definition


def pack(package: str, registry: Registry) -> str:
    """Return the text of the file with all definitions of a package."""
    sections = [f"# Interfaces of the ROS 2 package {package}; made by packing.py.\n"]
    for interface in registry.packages[package].interfaces():
        kind = interface.partition("/")[0]
        parts = (registry.read(f"{package}/{interface}{suffix}") for suffix in PARTS[kind])
        body = "---\n".join(map(definition, parts))
        sections.append(f"[{interface}]\n{body}")
    return "\n".join(sections)


def main(distribution: str, folder: str, *packages: str) -> None:
    """Write the files of some or all packages of a folder."""
    registry = Registry(packages_in(Path(folder)))
    for package in packages or sorted(registry.packages):
        target = DATA / distribution / f"{package}.interfaces"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(pack(package, registry), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
