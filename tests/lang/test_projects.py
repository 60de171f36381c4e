"""Settings of projects."""

import math
from pathlib import Path

import pytest

from seoro.errors import UsageError
from seoro.lang.projects import SETTINGS, TEST_SETTINGS, project_of


def test_the_nearest_folder_upwards_counts(tmp_path: Path) -> None:
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)
    (tmp_path / "pyproject.toml").write_text('[tool.seoro]\nsimulator = "mujoco"\n')
    assert project_of(inner / "x.osc").values == {"simulator": "mujoco"}  # type: ignore[union-attr]
    (tmp_path / "a" / "pyproject.toml").write_text('[project]\nname = "other"\n')
    assert project_of(inner).file == tmp_path / "pyproject.toml"  # type: ignore[union-attr]
    (tmp_path / "a" / "seoro.toml").write_text('simulator = "pybullet"\n')
    (tmp_path / "a" / "pyproject.toml").write_text('[tool.seoro]\nsimulator = "mujoco"\n')
    assert project_of(inner).values == {"simulator": "pybullet"}  # type: ignore[union-attr]


def test_a_folder_without_settings_has_no_project(tmp_path: Path) -> None:
    assert project_of(tmp_path) is None


def test_paths_are_relative_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "seoro.toml").write_text(
        'world = "worlds/hall.yaml?generate.seed=3"\nrate = "max"\nmodel-path = ["models", "/opt/models"]\n'
        'lab = "../lab.yaml"\nlibraries = ["./libs"]\n[test]\npaths = ["scenarios"]\njobs = 4\n'
    )
    found = project_of(tmp_path)
    assert found is not None
    assert found.values == {
        "world": f"{tmp_path}/worlds/hall.yaml?generate.seed=3",
        "rate": math.inf,
        "model-path": (tmp_path / "models", Path("/opt/models")),
        "lab": tmp_path.parent / "lab.yaml",
        "libraries": (tmp_path / "libs",),
    }
    assert found.test == {"paths": (tmp_path / "scenarios",), "jobs": 4}


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "seoro.toml"
    file.write_text('simulator = "mujoco"\n')
    project_of(tmp_path)
    file.write_text('simulator = "pybullet"\n')
    assert project_of(tmp_path).values == {"simulator": "pybullet"}  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ('\nsimulatr = "mujoco"\n', "seoro.toml:2: unknown setting `simulatr`", "did you mean `simulator`?"),
        ("[test]\njbs = 2\n", "seoro.toml:2: unknown setting `jbs`", "did you mean `jobs`?"),
        ("[tests]\njobs = 2\n", "seoro.toml:1: unknown setting `tests`", "settings: simulator"),
        ("rate = 0\n", 'seoro.toml:1: `rate` is 0; expected a positive number, or "max"', ""),
        ("rate = true\n", "`rate` is True; expected a positive number", ""),
        ('timeout = "1h"\n', "`timeout` is '1h'; expected a positive number of seconds", ""),
        ('libraries = "libs"\n', "`libraries` is 'libs'; expected a list of paths", ""),
        ('ignore = ["E9999"]\n', "`ignore` is ['E9999']; expected ", ""),
        ('ignore = "E0702"\n', "`ignore` is 'E0702'; expected a list of codes", ""),
        ("test = 3\n", "expected a table `test`, found 3", ""),
        ("[test]\njobs = -1\n", "`jobs` is -1; expected a whole number from 0", ""),
        ('lab = "a.yaml"\nsimulator = "mujoco"\n', "`lab` contradicts `simulator`", "leave out one"),
        ("simulator = \n", "cannot read the settings of the project in", ""),
    ],
)
def test_invalid_settings_are_refused_with_their_place(text: str, message: str, hint: str, tmp_path: Path) -> None:
    (tmp_path / "seoro.toml").write_text(text)
    with pytest.raises(UsageError) as caught:
        project_of(tmp_path)
    assert message in str(caught.value)
    assert hint in (caught.value.help or "")


def test_all_settings_have_a_meaning() -> None:
    assert all(setting.meaning for setting in (*SETTINGS.values(), *TEST_SETTINGS.values()))
