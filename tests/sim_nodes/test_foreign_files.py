"""Files of others in the place of worlds: maps with keys of others are read, and what is no world is explained."""

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
    assert world.warnings == (f"{folder / 'room.yaml'}:4: unknown key `laser_height` of a map is ignored",)


def test_a_map_in_the_place_of_a_world_is_told_how_a_world_names_it(folder: Path) -> None:
    with pytest.raises(WorldError, match=r"room.yaml is a map, not a world; expected .*`floor_plan: room.yaml`"):
        load_world(str(folder / "room.yaml"))


@pytest.mark.parametrize("name", ["world.sdf", "world.xml", "world"])
def test_a_file_that_is_no_world_file_is_not_missing(folder: Path, name: str) -> None:
    (folder / name).write_text("<sdf/>")
    with pytest.raises(WorldError, match=r"is no world file of seoro \(.yaml\)") as caught:
        load_world(str(folder / name))
    assert not caught.value.missing
    (folder / name).unlink()
    with pytest.raises(WorldError, match="there is no world"):
        load_world(str(folder / name))


def test_a_picture_that_says_that_it_is_huge_is_refused_by_its_number_of_pixels(folder: Path) -> None:
    (folder / "room.pgm").write_bytes(b"P5\n60000 60000\n255\n\xff")
    with pytest.raises(WorldError, match=r"world.yaml:2: floor_plan: .*room.pgm has more than 4000000 pixels"):
        load_world(str(folder / "world.yaml"))
    (folder / "room.pgm").write_bytes(b"P5\n9500 9500\n255\n\xff")
    with pytest.raises(WorldError, match="more than 4000000"):
        load_world(str(folder / "world.yaml"))


def chunk(kind: bytes, data: bytes) -> bytes:
    """A chunk of a PNG."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_a_png_that_says_that_it_is_huge_is_refused_too(folder: Path) -> None:
    header = struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)
    chunks = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")
    (folder / "room.pgm").write_bytes(b"\x89PNG\r\n\x1a\n" + chunks)
    with pytest.raises(WorldError, match="more than 4000000 pixels"):
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
