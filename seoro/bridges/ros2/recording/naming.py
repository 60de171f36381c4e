"""What bags are called, and in which storage they are written."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Final

from seoro.bridges.ros2.recording.errors import RefusedRecording

DEFAULT_NAME: Final = "rosbag2"
STORAGES: Final = ("", "mcap")  # nothing is what seoro chooses


def bag_folder(parent: Path, name: str = DEFAULT_NAME, at: datetime | None = None) -> Path:
    """The folder of a bag that is recorded.

    Args:
        parent: Where bags go.
        name: Of the bag.
        at: Time for its name, as rosbag2 has it (`rosbag2_2024_05_31-16_04_05`); none when None.
    """
    return parent / (name if at is None else f"{name}_{at:%Y_%m_%d-%H_%M_%S}")


def check_storage(storage: str) -> None:
    """Refuse storages in which bags are not written.

    Raises:
        RefusedRecording: It is such a storage.
    """
    if storage not in STORAGES:
        raise RefusedRecording(
            f"bags are recorded in the storage `mcap`, not in `{storage}`",
            help="leave it out; `rosbags-convert` of the package rosbags makes other bags of it",
        )
