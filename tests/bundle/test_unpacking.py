"""Laying bundles out: what comes from elsewhere writes nothing outside of its folder."""

import hashlib
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bundle.unpacking import InvalidBundle, check_manifest, options_of, unpack
from seoro.errors import InvalidUse

DATA = b"struct thing\n"
HASH = hashlib.sha256(DATA).hexdigest()


def file(path: str, digest: str = HASH, size: int = len(DATA)) -> wire.BundleFile:
    return wire.BundleFile(path=path, hash=digest, size=size)


def manifest(*files: wire.BundleFile, entry: str = "main.osc", **options: Any) -> wire.Manifest:
    given = wire.BundledOptions.model_validate({"grace": 5.0, "overrides": {}, **options})
    return wire.Manifest(files=files or (file("main.osc"),), entry=entry, shown="main.osc", options=given)


@pytest.fixture
def blobs(tmp_path: Path) -> Path:
    folder = tmp_path / "blobs"
    folder.mkdir()
    (folder / HASH).write_bytes(DATA)
    return folder


def test_files_lie_where_the_manifest_says(tmp_path: Path, blobs: Path) -> None:
    found = manifest(file("main.osc"), file("common/robots.osc"))
    check_manifest(found)
    unpack(found, lambda digest: blobs / digest, tmp_path / "out")
    assert (tmp_path / "out/common/robots.osc").read_bytes() == DATA


@pytest.mark.parametrize("path", ["../x.osc", "/tmp/x.osc", "a/../../x.osc", "a\\..\\x"])
def test_paths_that_lead_out_are_refused(path: str) -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest(file("main.osc"), file(path)))


def test_a_working_directory_outside_is_refused() -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest().model_copy(update={"directory": "../.."}))


@pytest.mark.parametrize("other", ["main.osc", "main.osc/inside.osc"])
def test_two_files_at_one_place_are_refused(other: str) -> None:
    with pytest.raises(InvalidBundle, match="same place"):
        check_manifest(manifest(file("main.osc"), file(other)))


@pytest.mark.parametrize(
    "options",
    [
        {"parameters": "/etc/passwd"},
        {"simulator": {"name": "mujoco", "rate": 1.0, "snapshot": "../x"}},
        {"simulator": {"name": "mujoco", "rate": 1.0, "model_path": ["/etc"]}},
        {"simulator": {"name": "mujoco", "rate": 1.0, "world": "/etc/world.yaml"}},
        {"simulator": {"name": "mujoco", "rate": 1.0, "world_file": "../hall.yaml"}},
        {"simulator": {"name": "ros", "rate": 1.0, "world_file": "../hall.sdf"}},
        {"lab": {"file": "lab.yaml"}},
        {"ros": {"endpoint": "tcp/127.0.0.1:7447", "interfaces": [".."]}},
    ],
)
def test_options_that_name_files_outside_of_the_bundle_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest(**options))


def test_a_root_that_is_no_absolute_path_is_refused() -> None:
    with pytest.raises(InvalidBundle, match="no absolute path"):
        check_manifest(manifest().model_copy(update={"root": "home"}))


def test_an_entry_that_is_not_there_is_refused() -> None:
    with pytest.raises(InvalidBundle, match=r"other\.osc"):
        check_manifest(manifest(entry="other.osc"))


def test_too_much_is_refused() -> None:
    files = [file(f"{number}.osc", size=wire.MAX_FILE) for number in range(5)]
    with pytest.raises(InvalidBundle, match="larger"):
        check_manifest(manifest(file("main.osc"), *files))


def test_a_blob_with_other_content_is_refused(tmp_path: Path, blobs: Path) -> None:
    (blobs / HASH).write_bytes(b"something else")
    with pytest.raises(InvalidBundle, match="not what the manifest says"):
        unpack(manifest(), lambda digest: blobs / digest, tmp_path / "out")


def test_options_are_checked_as_those_of_a_run_here(tmp_path: Path) -> None:
    with pytest.raises(InvalidUse, match="no clock 'moon'"):
        options_of(manifest(clock="moon"), tmp_path)
    with pytest.raises(InvalidUse, match="rate"):
        options_of(manifest(simulator={"name": "mujoco", "rate": -1.0}), tmp_path)


def test_a_lab_that_names_the_file_of_a_world_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco, world: ../../secret.yaml}\n")
    with pytest.raises(InvalidUse, match=r"secret\.yaml of the lab is not sent"):
        options_of(manifest(lab={"file": "lab.yaml"}), tmp_path)


def test_worlds_are_those_of_the_bundle(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("name: hall\n")
    (tmp_path / "lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco, world: hall.yaml}\n")
    assert options_of(manifest(lab={"file": "lab.yaml"}), tmp_path).lab is not None
    given = {"name": "mujoco", "rate": 1.0, "world_file": "hall.yaml"}
    simulator = options_of(manifest(simulator=given), tmp_path).simulator
    assert simulator is not None
    assert simulator.world == str(tmp_path / "hall.yaml")
    given = {"name": "ros", "rate": 1.0, "world_file": "hall.yaml", "world_by_uri": True}
    simulator = options_of(manifest(simulator=given), tmp_path).simulator
    assert simulator is not None
    assert simulator.world == f"file://{tmp_path}/hall.yaml"
