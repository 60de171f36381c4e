"""Entry points of packages, as an installation writes them."""

from __future__ import annotations

from pathlib import Path


def add_entry_points(site: Path, name: str, text: str, version: str = "1.0") -> None:
    """Write the metadata of an installed package.

    Args:
        site: Folder of installed packages.
        name: Name of the package.
        text: Content of its `entry_points.txt`.
        version: Its version.
    """
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (info / "entry_points.txt").write_text(text)
