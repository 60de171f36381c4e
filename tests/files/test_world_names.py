"""Names of worlds with parameters, and the places that locate their files."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bundle.paths import is_world_name
from seoro.files.world_names import WorldName


@pytest.mark.parametrize("text", ["maze", "maze?wall_height=1.5", "a/hall.yaml", "hall.yaml?generate.seed=3&x=y"])
def test_names_are_written_as_they_are_read(text: str) -> None:
    assert str(WorldName.parse(text)) == text


def test_only_files_are_located() -> None:
    def locate(path: Path) -> Path:
        return Path("/here") / path

    assert WorldName.parse("maze?a=1.5").located(locate) == "maze?a=1.5"
    assert WorldName.parse("hall.yaml?a=1").located(locate) == "/here/hall.yaml?a=1"
    for suffix in ("yml", "png", "PGM", "jpg", "sdf", "world", "xml"):
        assert WorldName.parse(f"hall.{suffix}").is_file


def test_parameters_do_not_make_a_name_a_file() -> None:
    assert is_world_name("maze?wall_height=1.5")
    assert not is_world_name("hall.yaml?a=1")
