from __future__ import annotations

import os
from pathlib import Path

import pytest

from seoro.bridges.model_files import InvalidModel, gather, virtual_path
from seoro.bridges.models import ModelNotFound, ModelPath

NAMES = '<mesh filename="{}"/>'


def model(folder: Path, *names: str, file: str = "robot.urdf") -> Path:
    path = folder / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(map(NAMES.format, names)))
    return path


def write(path: Path, text: str = "x") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("named", "folder", "path"),
    [
        ("a.stl", "", "a.stl"),
        ("./b/../a.stl", "meshes", "meshes/a.stl"),
        ("package://arm/a.stl", "meshes", "package/arm/a.stl"),
        ("model://arm/my%20a.stl", "", "model/arm/my a.stl"),
        ("file:///tmp/a.stl", "", "/tmp/a.stl"),
        ("meshes\\a.stl", "", "meshes/a.stl"),
    ],
)
def test_virtual_paths_are_the_same_on_every_machine(named: str, folder: str, path: str) -> None:
    assert virtual_path(named, folder) == path
    assert virtual_path(path) == path


def test_relative_files_are_read_with_materials_and_textures(tmp_path: Path) -> None:
    write(tmp_path / "meshes/a.obj", "mtllib a.mtl\nv 0 0 0\n")
    write(tmp_path / "meshes/a.mtl", "newmtl skin\nmap_Kd skin.png\n")
    write(tmp_path / "meshes/skin.png", "picture")
    found = gather(model(tmp_path, "meshes/a.obj"))
    assert dict(found.files)["meshes/skin.png"] == b"picture"
    assert set(found.files) == {"meshes/a.obj", "meshes/a.mtl", "meshes/skin.png"}
    assert {path.name for path in found.paths} == {"a.obj", "a.mtl", "skin.png"}


def test_files_may_be_named_from_a_folder_above_the_model(tmp_path: Path) -> None:
    write(tmp_path / "models/gears/ring.stl", "near")
    write(tmp_path / "outside/ring.stl", "far")
    path = model(tmp_path / "models/gears", "gears/ring.stl", "outside/ring.stl")
    assert dict(gather(path).files) == {"gears/ring.stl": b"near", "outside/ring.stl": b"far"}
    assert set(gather(path, [tmp_path / "models"]).files) == {"gears/ring.stl"}


def test_packages_are_searched_above_the_model_and_in_environment_variables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "arm/meshes/a.stl")
    write(tmp_path / "elsewhere/share/hand/meshes/b.stl")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "elsewhere"))
    path = model(tmp_path / "arm/urdf", "package://arm/meshes/a.stl", "package://hand/meshes/b.stl")
    assert set(gather(path).files) == {"package/arm/meshes/a.stl", "package/hand/meshes/b.stl"}


def test_files_of_mjcf_are_searched_in_its_folders(tmp_path: Path) -> None:
    write(tmp_path / "assets/a.stl")
    write(tmp_path / "shared.xml", '<mujoco><asset><mesh file="b.stl"/></asset></mujoco>')
    write(tmp_path / "assets/b.stl")
    parts = '<compiler meshdir="assets"/><include file="shared.xml"/><asset><mesh file="a.stl"/></asset>'
    found = gather(write(tmp_path / "model.xml", f"<mujoco>{parts}</mujoco>"))
    assert set(found.files) == {"assets/a.stl", "shared.xml", "assets/b.stl"}


def test_comments_name_no_files(tmp_path: Path) -> None:
    write(tmp_path / "a.stl")
    path = write(tmp_path / "robot.urdf", "<!-- " + NAMES.format("a.stl") + " -->")
    assert gather(path).files == {}


def test_missing_and_special_files_are_left_out(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.stl")
    (tmp_path / "folder.stl").mkdir()
    assert gather(model(tmp_path, "none.stl", "pipe.stl", "folder.stl", "/dev/zero")).files == {}


def test_files_outside_of_the_allowed_folders_are_left_out(tmp_path: Path) -> None:
    write(tmp_path / "secret.stl")
    (tmp_path / "models").mkdir()
    (tmp_path / "models/link.stl").symlink_to(tmp_path / "secret.stl")
    path = model(tmp_path / "models", "../secret.stl", str(tmp_path / "secret.stl"), "link.stl")
    assert len(gather(path).files) == 3
    assert gather(path, [tmp_path / "models"]).files == {}


def test_models_of_the_model_path_name_files_of_their_folders_only(tmp_path: Path) -> None:
    write(tmp_path / "secret.stl")
    write(tmp_path / "models/shop/meshes/a.stl")
    model(tmp_path / "models/shop", "meshes/a.stl", "../../secret.stl")
    found = ModelPath([tmp_path / "models"]).read("shop://robot.urdf")
    assert set(found.files) == {"meshes/a.stl"}


def test_too_many_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.model_files.MAX_FILES", 2)
    names = [f"{number}.stl" for number in range(3)]
    for name in names:
        write(tmp_path / name)
    with pytest.raises(InvalidModel, match=r"robot\.urdf names more than 2 files"):
        gather(model(tmp_path, *names))
    with pytest.raises(ModelNotFound, match="names more than 2 files"):
        ModelPath().read(f"file://{tmp_path}/robot.urdf")


def test_unreadable_models_are_refused(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_bytes(b"\xff\xfe")
    with pytest.raises(InvalidModel, match="not UTF-8"):
        gather(tmp_path / "robot.urdf")
    with pytest.raises(InvalidModel, match="No such file"):
        gather(tmp_path / "none.urdf")
