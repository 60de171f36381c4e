"""Lists of the files of a world, for copying it to another machine."""

import json
import shutil
from pathlib import Path

import pytest

from sim_nodes.worlds.files import files_of_world, main
from sim_nodes.worlds.loader import WorldError
from tests.sim_nodes.models.test_mjcf import WEDGE

WORKSHOP = Path(__file__).parents[2] / "examples/workshop"


@pytest.fixture
def workshop(tmp_path: Path) -> Path:
    return Path(shutil.copytree(WORKSHOP, tmp_path / "workshop")) / "workshop.yaml"


def test_files_of_a_world_include_plan_robots_and_models(workshop: Path) -> None:
    found = {path.name for path in files_of_world(str(workshop))}
    assert found == {
        "workshop.yaml", "plan.yaml", "plan.png", "cart.yaml", "cart.urdf", "shelf.urdf", "trestle.xml",
    }  # fmt: skip


def test_files_of_a_world_include_the_image_of_an_inline_plan(workshop: Path) -> None:
    plan = "{image: plan.png, resolution: 0.05, origin: [-4.0, -3.0, 0.0]}"
    workshop.write_text(f"name: bare\nfloor_plan: {plan}\n")
    assert {path.name for path in files_of_world(str(workshop))} == {"workshop.yaml", "plan.png"}


def test_files_of_a_world_include_the_meshes_of_models(workshop: Path) -> None:
    meshes = workshop.parent / "meshes"
    meshes.mkdir()
    (meshes / "wedge.stl").write_bytes(WEDGE)
    shelf = workshop.parent / "shelf.urdf"
    mesh = '<visual><geometry><mesh filename="meshes/wedge.stl"/></geometry></visual></link>'
    shelf.write_text(shelf.read_text().replace("</link>", mesh, 1))
    assert meshes / "wedge.stl" in files_of_world(str(workshop))


def test_missing_files_are_reported(workshop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (workshop.parent / "cart.urdf").unlink()
    with pytest.raises(WorldError, match=r"cart\.urdf"):
        list(files_of_world(str(workshop)))
    assert main([str(workshop)]) == 1
    assert "cart.urdf" in capsys.readouterr().err


def test_the_command_prints_json(workshop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(workshop)]) == 0
    assert str(workshop) in json.loads(capsys.readouterr().out)
