"""The same source gives the same distributions, wherever and whenever it is built."""

from __future__ import annotations

import os
import shutil
import subprocess
import tarfile
from pathlib import Path
from typing import Literal
from zipfile import ZipFile

import pytest

import seoro
from tests.distribution.building import ROOT, build

pytestmark = pytest.mark.more


def sources() -> list[str]:
    """Return the paths of all files of the tree under version control."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=False)
    if listed.returncode:
        pytest.skip("not a git work tree")
    return [name for name in listed.stdout.decode().split("\0") if (ROOT / name).is_file()]


def copy_tree(target: Path, age: float) -> Path:
    """Copy the tree with other times [s] and permissions of files."""
    for name in sources():
        copied = target / name
        copied.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, copied)
        copied.chmod(0o600 if age else 0o664)
        os.utime(copied, (1.6e9 - age, 1.6e9 - age))
    return target


@pytest.fixture(scope="module")
def trees(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return two copies of the tree."""
    return [copy_tree(tmp_path_factory.mktemp("tree"), age) for age in (0.0, 1e6)]


@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_two_builds_have_the_same_bytes(
    kind: Literal["wheel", "sdist"], trees: list[Path], tmp_path: Path
) -> None:
    first, second = (build(tmp_path / str(number), kind, tree) for number, tree in enumerate(trees))
    assert first.name == second.name
    assert first.read_bytes() == second.read_bytes()


def test_the_wheel_of_the_sdist_is_the_same(trees: list[Path], tmp_path: Path) -> None:
    direct = build(tmp_path / "direct", "wheel", trees[0])
    packed = build(tmp_path / "sdist", "sdist", trees[0])
    with tarfile.open(packed) as archive:
        archive.extractall(tmp_path / "unpacked", filter="data")
    again = build(tmp_path / "again", "wheel", tmp_path / "unpacked" / packed.name.removesuffix(".tar.gz"))
    assert again.read_bytes() == direct.read_bytes()


def test_the_wheel_has_the_packages_and_the_license_only(wheel: Path) -> None:
    with ZipFile(wheel) as archive:
        names = archive.namelist()
    information = f"seoro-{seoro.__version__}.dist-info"
    assert {name.partition("/")[0] for name in names} == {"seoro", "sim_nodes", information}
    assert f"{information}/licenses/LICENSE" in names
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]
