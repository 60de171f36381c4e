"""Folders with interface packages of users."""

from pathlib import Path

from seoro.bridges.ros2.interfaces import TypeStore


def make_folder(folder: Path, **files: str) -> Path:
    """Write a package `my_robot`: `Pose_msg="..."` becomes `my_robot/msg/Pose.msg`."""
    for name, text in files.items():
        stem, _, kind = name.rpartition("_")
        file = folder / "my_robot" / kind / f"{stem}.{kind}"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder


def store_with(folder: Path, **files: str) -> TypeStore:
    """Return the bundled interfaces with those of the package `my_robot`."""
    return TypeStore.bundled().add_folder(make_folder(folder, **files))
