"""Unpacking of bundles, which write nothing outside their folder."""

import hashlib
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bundle.unpack import InvalidBundle, check_manifest, read_options, unpack
from seoro.errors import UsageError

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


def test_files_are_unpacked_to_the_paths_of_the_manifest(tmp_path: Path, blobs: Path) -> None:
    found = manifest(file("main.osc"), file("common/robots.osc"))
    check_manifest(found)
    unpack(found, lambda digest: blobs / digest, tmp_path / "out")
    assert (tmp_path / "out/common/robots.osc").read_bytes() == DATA


@pytest.mark.parametrize("path", ["../x.osc", "/tmp/x.osc", "a/../../x.osc", "a\\..\\x"])
def test_paths_out_of_the_folder_are_refused(path: str) -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest(file("main.osc"), file(path)))


def test_a_working_directory_outside_is_refused() -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest().model_copy(update={"directory": "../.."}))


@pytest.mark.parametrize("other", ["main.osc", "main.osc/inside.osc"])
def test_two_files_with_one_path_are_refused(other: str) -> None:
    with pytest.raises(InvalidBundle, match="same path"):
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
def test_options_with_files_outside_of_the_bundle_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises(InvalidBundle):
        check_manifest(manifest(**options))


def test_a_relative_root_is_refused() -> None:
    with pytest.raises(InvalidBundle, match="not an absolute path"):
        check_manifest(manifest().model_copy(update={"root": "home"}))


def test_a_missing_entry_file_is_refused() -> None:
    with pytest.raises(InvalidBundle, match=r"other\.osc"):
        check_manifest(manifest(entry="other.osc"))


def test_a_too_large_bundle_is_refused() -> None:
    files = [file(f"{number}.osc", size=wire.MAX_FILE) for number in range(5)]
    with pytest.raises(InvalidBundle, match="larger"):
        check_manifest(manifest(file("main.osc"), *files))


def test_a_blob_with_other_content_is_refused(tmp_path: Path, blobs: Path) -> None:
    (blobs / HASH).write_bytes(b"something else")
    with pytest.raises(InvalidBundle, match="differs from the manifest"):
        unpack(manifest(), lambda digest: blobs / digest, tmp_path / "out")


def test_options_are_checked_as_in_a_local_run(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="unknown clock 'moon'"):
        read_options(manifest(clock="moon"), tmp_path)
    with pytest.raises(UsageError, match="rate"):
        read_options(manifest(simulator={"name": "mujoco", "rate": -1.0}), tmp_path)


def test_a_lab_with_a_world_file_outside_of_the_bundle_is_refused(tmp_path: Path) -> None:
    (tmp_path / "lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco, world: ../../secret.yaml}\n")
    with pytest.raises(UsageError, match=r"missing world file .*secret\.yaml of the lab"):
        read_options(manifest(lab={"file": "lab.yaml"}), tmp_path)


def test_world_files_are_read_from_the_bundle(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("name: hall\n")
    (tmp_path / "lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco, world: hall.yaml}\n")
    assert read_options(manifest(lab={"file": "lab.yaml"}), tmp_path).lab is not None
    given = {"name": "mujoco", "rate": 1.0, "world_file": "hall.yaml"}
    simulator = read_options(manifest(simulator=given), tmp_path).simulator
    assert simulator is not None
    assert simulator.world == str(tmp_path / "hall.yaml")
    given = {"name": "ros", "rate": 1.0, "world_file": "hall.yaml", "world_by_uri": True}
    simulator = read_options(manifest(simulator=given), tmp_path).simulator
    assert simulator is not None
    assert simulator.world == f"file://{tmp_path}/hall.yaml"
