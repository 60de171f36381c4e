"""Which files a world consists of, for those who send it elsewhere."""

import json
import shutil
from pathlib import Path

import pytest

from sim_nodes.worlds.files import files_of_world, main
from sim_nodes.worlds.loader import WorldError

WORKSHOP = Path(__file__).parents[2] / "examples/workshop"


@pytest.fixture
def workshop(tmp_path: Path) -> Path:
    return Path(shutil.copytree(WORKSHOP, tmp_path / "workshop")) / "workshop.yaml"


def test_a_world_has_its_plan_its_robots_and_its_models(workshop: Path) -> None:
    found = {path.name for path in files_of_world(workshop)}
    assert found == {
        "workshop.yaml", "plan.yaml", "plan.png", "cart.yaml", "cart.urdf", "shelf.urdf", "trestle.xml",
    }  # fmt: skip


def test_a_plan_in_the_world_file_itself_has_its_picture(workshop: Path) -> None:
    plan = "{image: plan.png, resolution: 0.05, origin: [-4.0, -3.0, 0.0]}"
    workshop.write_text(f"name: bare\nfloor_plan: {plan}\n")
    assert {path.name for path in files_of_world(workshop)} == {"workshop.yaml", "plan.png"}


def test_what_is_missing_is_told(workshop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (workshop.parent / "cart.urdf").unlink()
    with pytest.raises(WorldError, match=r"cart\.urdf"):
        list(files_of_world(workshop))
    assert main([str(workshop)]) == 1
    assert "cart.urdf" in capsys.readouterr().err


def test_the_command_prints_json(workshop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(workshop)]) == 0
    assert str(workshop) in json.loads(capsys.readouterr().out)
