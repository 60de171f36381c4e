"""Foreign files as worlds: unknown keys of maps are ignored, and other formats are refused with a hint."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

import pytest

from sim_nodes.worlds.loader import WorldError, load_world

MAP = """image: room.pgm
resolution: 0.05
origin: [0.0, 0.0, 0.0]
laser_height: 0.2
negate: 0
occupied_thresh: 0.65
free_thresh: 0.25
"""
WORLD = """name: room
floor_plan: room.yaml
robots:
  - {name: turtlebot4, robot: turtlebot4, pose: {x: 2.0, y: 2.0}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "room.pgm").write_bytes(b"P5\n100 100\n255\n" + b"\xff" * 10_000)
    (tmp_path / "room.yaml").write_text(MAP)
    (tmp_path / "world.yaml").write_text(WORLD)
    return tmp_path


def test_keys_of_a_map_that_the_map_server_ignores_are_ignored_with_a_warning(folder: Path) -> None:
    world = load_world(str(folder / "world.yaml"))
    assert world.extent == (0.0, 0.0, 5.0, 5.0)
    assert world.warnings == (f"{folder / 'room.yaml'}:4: ignored unknown key `laser_height` of a map",)


@pytest.mark.parametrize("name", ["world.txt", "world"])
def test_an_unsupported_world_format_is_distinguished_from_a_missing_file(folder: Path, name: str) -> None:
    (folder / name).write_text("<sdf/>")
    with pytest.raises(WorldError, match=r"unsupported world format: .*expected a world file \(.yaml\)") as caught:
        load_world(str(folder / name))
    assert not caught.value.missing
    (folder / name).unlink()
    with pytest.raises(WorldError, match="unknown world"):
        load_world(str(folder / name))


def test_an_image_with_too_many_pixels_is_refused(folder: Path) -> None:
    (folder / "room.pgm").write_bytes(b"P5\n60000 60000\n255\n\xff")
    with pytest.raises(
        WorldError, match=r"world.yaml:2: floor_plan: .*room.pgm has too many pixels; expected at most 4000000"
    ):
        load_world(str(folder / "world.yaml"))
    (folder / "room.pgm").write_bytes(b"P5\n9500 9500\n255\n\xff")
    with pytest.raises(WorldError, match=r"too many pixels|expected at most 4000000"):
        load_world(str(folder / "world.yaml"))


def chunk(kind: bytes, data: bytes) -> bytes:
    """Return a chunk of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_a_png_with_a_huge_declared_size_is_refused(folder: Path) -> None:
    header = struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)
    chunks = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")
    (folder / "room.pgm").write_bytes(b"\x89PNG\r\n\x1a\n" + chunks)
    with pytest.raises(WorldError, match="expected at most 4000000"):
        load_world(str(folder / "world.yaml"))


@pytest.mark.parametrize("name", ["world.yaml", "room.yaml", "room.pgm"])
def test_pipes_and_devices_are_not_read(folder: Path, name: str) -> None:
    (folder / name).unlink()
    os.mkfifo(folder / name)
    with pytest.raises(WorldError, match="it is a pipe; expected a regular file"):
        load_world(str(folder / "world.yaml"))
    (folder / name).unlink()
    (folder / name).symlink_to("/dev/zero")
    with pytest.raises(WorldError, match="it is a device; expected a regular file"):
        load_world(str(folder / "world.yaml"))
