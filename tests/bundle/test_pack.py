"""Files of packed bundles."""

import shutil
from pathlib import Path

import pytest

from seoro.bundle import worlds
from seoro.bundle.pack import Bundle, pack
from seoro.bundle.unpack import check_manifest, read_options
from seoro.embed import check_file
from seoro.embed.options import Lab, Options, Simulator
from seoro.errors import UsageError


def bundle(file: Path, options: Options | None = None) -> Bundle:
    scenario = check_file(file, import_python=False)
    assert not scenario.checked.errors, scenario.checked.errors
    return pack(scenario, options or Options())


def paths(found: Bundle) -> list[str]:
    return [file.path for file in found.manifest.files]


def write(
    path: Path, text: str = "import osc.helpers\nscenario main:\n    do serial:\n        log('x')\n"
) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text.replace("'", '"'))
    return path


def test_a_scenario_without_imports_is_one_file(tmp_path: Path) -> None:
    found = bundle(write(tmp_path / "main.osc"))
    assert paths(found) == ["main.osc"]
    assert found.manifest.entry == "main.osc"
    assert found.manifest.shown == str(tmp_path / "main.osc")


def test_imported_files_are_packed_at_their_relative_paths(tmp_path: Path) -> None:
    write(tmp_path / "common/robots.osc", "struct thing\n")
    write(tmp_path / "unrelated.osc", "struct other\n")
    text = "import '../common/robots.osc'\nimport osc.helpers\nscenario main:\n    do serial:\n        log('x')\n"
    found = bundle(write(tmp_path / "tests/main.osc", text))
    assert paths(found) == ["common/robots.osc", "tests/main.osc"]
    assert found.manifest.entry == "tests/main.osc"


def test_local_libraries_are_packed_with_their_python_files(tmp_path: Path) -> None:
    write(tmp_path / "seoro.libraries/mine/mine.osc", "action greet\n")
    write(tmp_path / "seoro.libraries/mine/__init__.py", "1 / 0\n")  # is not run here
    write(tmp_path / "seoro.libraries/mine/__pycache__/x.pyc", "")
    found = bundle(write(tmp_path / "main.osc", "import osc.mine\nscenario main:\n    do greet()\n"))
    assert paths(found) == ["main.osc", "seoro.libraries/mine/__init__.py", "seoro.libraries/mine/mine.osc"]


def test_libraries_of_a_project_are_packed_with_its_settings(tmp_path: Path) -> None:
    write(tmp_path / "seoro.toml", 'libraries = ["libs"]\n')
    write(tmp_path / "libs/mine.osc", "action greet\n")
    write(tmp_path / "libs/mine.py", "1 / 0\n")
    found = bundle(write(tmp_path / "scenarios/main.osc", "import osc.mine\nscenario main:\n    do greet()\n"))
    assert paths(found) == ["libs/mine.osc", "libs/mine.py", "scenarios/main.osc", "seoro.toml"]


def test_files_and_folders_of_the_options_are_packed(tmp_path: Path) -> None:
    write(tmp_path / "models/box/box.sdf", "<sdf/>")
    simulator = Simulator(name="mujoco", world="maze", model_path=[tmp_path / "models"])
    params = write(tmp_path / "p.yaml", "main: {}\n")
    found = bundle(write(tmp_path / "main.osc"), Options(simulator=simulator, parameters=params))
    assert paths(found) == ["main.osc", "models/box/box.sdf", "p.yaml"]
    options = found.manifest.options
    assert options.parameters == "p.yaml"
    assert options.simulator is not None
    assert options.simulator.model_path == ("models",)


def test_equal_files_are_one_blob(tmp_path: Path) -> None:
    write(tmp_path / "models/a/x.sdf", "<sdf/>")
    write(tmp_path / "models/b/x.sdf", "<sdf/>")
    simulator = Simulator(name="mujoco", model_path=[tmp_path / "models"])
    found = bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))
    assert len(found.manifest.files) == 3
    assert len(found.blobs) == 2


def test_an_absolute_import_is_packed_with_its_own_imports(tmp_path: Path) -> None:
    write(tmp_path / "common/more.osc", "struct more\n")
    other = write(tmp_path / "common/other.osc", "import 'more.osc'\nstruct thing\n")
    text = f"import osc.types\nimport '{other}'\nscenario main:\n    do serial:\n        wait elapsed(1s)\n"
    found = bundle(write(tmp_path / "tests/main.osc", text))
    assert paths(found) == ["common/more.osc", "common/other.osc", "tests/main.osc"]
    assert found.manifest.root == str(tmp_path)
    assert found.names_absolute


def test_packed_paths_are_relative_to_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "tests/main.osc")
    monkeypatch.chdir(tmp_path)
    found = bundle(Path("tests/main.osc"))
    assert paths(found) == ["tests/main.osc"]
    assert not found.names_absolute


WORKSHOP = Path(__file__).parents[2] / "examples/workshop"
ITS_FILES = ["cart.urdf", "cart.yaml", "plan.png", "plan.yaml", "shelf.urdf", "trestle.xml", "workshop.yaml"]


def test_a_world_file_is_packed_with_its_files(tmp_path: Path) -> None:
    shutil.copytree(WORKSHOP, tmp_path / "workshop")
    simulator = Simulator(name="mujoco", world=str(tmp_path / "workshop/workshop.yaml"))
    found = bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))
    assert paths(found) == ["main.osc", *(f"workshop/{name}" for name in ITS_FILES)]
    sent = found.manifest.options.simulator
    assert sent is not None
    assert (sent.world, sent.world_file) == (None, "workshop/workshop.yaml")


@pytest.mark.more
def test_the_world_of_a_lab_is_packed_with_its_files(tmp_path: Path) -> None:
    shutil.copytree(WORKSHOP, tmp_path / "workshop")
    lab = write(tmp_path / "lab.yaml", "simulators:\n  sim: {simulator: mujoco, world: workshop/workshop.yaml}\n")
    found = bundle(write(tmp_path / "main.osc"), Options(lab=Lab(lab)))
    assert paths(found) == ["lab.yaml", "main.osc", *(f"workshop/{name}" for name in ITS_FILES)]


def test_a_missing_file_of_a_world_is_refused_before_the_upload(tmp_path: Path) -> None:
    shutil.copytree(WORKSHOP, tmp_path / "workshop")
    (tmp_path / "workshop/plan.png").unlink()
    simulator = Simulator(name="mujoco", world=str(tmp_path / "workshop/workshop.yaml"))
    with pytest.raises(UsageError, match=r"plan\.png"):
        bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))


def test_a_reset_scenario_with_an_absolute_path_is_refused(tmp_path: Path) -> None:
    reset = write(tmp_path / "reset.osc")
    text = "simulators:\n  sim: {simulator: mujoco}\nrobots:\n"
    text += f"  a: {{in: sim, as: b, after: {{scenario: {reset}}}}}\n"
    lab = write(tmp_path / "lab.yaml", text)
    with pytest.raises(UsageError, match=r"reset scenario of `a` has an absolute path, .*reset\.osc"):
        bundle(write(tmp_path / "main.osc"), Options(lab=Lab(lab)))


def test_reading_a_world_is_limited_in_processor_time(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pybullet")  # has the model
    monkeypatch.setattr(worlds, "PROCESSOR_TIME", 1)
    monkeypatch.setattr(worlds, "TIMEOUT", None)  # wall time depends on other processes
    dog = Path(__file__).parents[2] / "scenarios/catalogue/worlds/dog.yaml"
    with pytest.raises(UsageError, match=r"dog.yaml took more than 1 s of processor time"):
        worlds.files_of_world(str(dog))


@pytest.mark.more
def test_an_absolute_path_in_a_world_file_is_refused(tmp_path: Path) -> None:
    shutil.copytree(WORKSHOP, tmp_path / "workshop")
    world = tmp_path / "workshop/workshop.yaml"
    world.write_text(world.read_text().replace("cart.yaml", f"{tmp_path}/workshop/cart.yaml"))
    with pytest.raises(UsageError, match=r"absolute path .*cart\.yaml in "):
        bundle(write(tmp_path / "main.osc"), Options(simulator=Simulator(name="mujoco", world=str(world))))


def test_an_invalid_world_name_is_refused(tmp_path: Path) -> None:
    simulator = Simulator(name="mujoco", world="hall.txt")
    with pytest.raises(UsageError, match="expected the name of a world, or a world file"):
        bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))


SDF = """<sdf><world name='hall'>
  <include><uri>model://sun</uri></include>
  <include><uri>models/box</uri></include>
  <light><uri>https://example.org/light.sdf</uri></light>
  <mesh filename='../meshes/wall.dae'/><mesh filename='missing.dae'/><mesh filename='/etc/hostname'/>
</world></sdf>"""


def hall(folder: Path) -> Path:
    write(folder / "worlds/models/box/model.sdf", "<sdf><uri>skin.png</uri></sdf>")
    write(folder / "worlds/models/box/skin.png")
    write(folder / "meshes/wall.dae", "x")
    write(folder / "worlds/unrelated.dae")
    return write(folder / "worlds/hall.sdf", SDF)


@pytest.mark.parametrize("by_uri", [False, True])
def test_a_world_file_of_another_simulator_is_packed_with_its_relative_files(tmp_path: Path, by_uri: bool) -> None:
    file = hall(tmp_path)
    simulator = Simulator(name="ros", world=file.as_uri() if by_uri else str(file))
    found = bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))
    box = "worlds/models/box"
    assert paths(found) == [
        "main.osc",
        "meshes/wall.dae",
        "worlds/hall.sdf",
        f"{box}/model.sdf",
        f"{box}/skin.png",
    ]
    sent = found.manifest.options.simulator
    assert sent is not None
    assert (sent.world, sent.world_file, sent.world_by_uri) == (None, "worlds/hall.sdf", by_uri)


@pytest.mark.parametrize("world", ["hall", "/opt/worlds/hall.sdf", "file:///nowhere/hall.sdf", "gz://hall", None])
def test_world_names_of_another_simulator_are_not_changed(tmp_path: Path, world: str | None) -> None:
    found = bundle(write(tmp_path / "main.osc"), Options(simulator=Simulator(name="ros", world=world)))
    assert paths(found) == ["main.osc"]
    check_manifest(found.manifest)
    simulator = read_options(found.manifest, tmp_path).simulator
    assert simulator is not None
    assert simulator.world == world


def test_a_broken_world_file_of_another_simulator_is_refused(tmp_path: Path) -> None:
    world = write(tmp_path / "hall.sdf", "<sdf>")
    with pytest.raises(UsageError, match=r"cannot read the world file .*hall\.sdf: no element found"):
        bundle(write(tmp_path / "main.osc"), Options(simulator=Simulator(name="ros", world=str(world))))


PLAY = "import osc.ros\nscenario main:\n    do bag_play('{source}')\n"


def test_a_played_bag_is_packed(tmp_path: Path) -> None:
    write(tmp_path / "bags/run/metadata.yaml", "x")
    write(tmp_path / "bags/run/run.mcap", "y")
    found = bundle(write(tmp_path / "main.osc", PLAY.format(source="bags/run")))
    assert paths(found) == ["bags/run/metadata.yaml", "bags/run/run.mcap", "main.osc"]


def test_a_missing_bag_is_reported_with_its_position(tmp_path: Path) -> None:
    file = write(tmp_path / "main.osc", PLAY.format(source="bags/run"))
    with pytest.raises(UsageError, match=r"file not found: .*bags/run") as caught:
        bundle(file)
    assert caught.value.span is not None
    assert caught.value.span.line == 3


def test_files_with_absolute_paths_are_packed(tmp_path: Path) -> None:
    bag = write(tmp_path / "bags/run/run.mcap", "y").parent
    model = write(tmp_path / "a model.sdf", "<sdf/>")
    text = f"import osc.ros\nimport osc.sim\nscenario main:\n    do serial:\n        bag_play('{bag}')\n"
    text += f"        spawn_entity('crate', '{model.as_uri()}', pose_3d())\n"
    found = bundle(write(tmp_path / "tests/main.osc", text))
    assert paths(found) == ["a model.sdf", "bags/run/run.mcap", "tests/main.osc"]
    assert found.names_absolute


@pytest.mark.more
def test_a_world_loaded_by_the_scenario_is_packed(tmp_path: Path) -> None:
    shutil.copytree(WORKSHOP, tmp_path / "workshop")
    text = f"import osc.sim\nscenario main:\n    do load_world('{tmp_path}/workshop/workshop.yaml')\n"
    found = bundle(write(tmp_path / "main.osc", text))
    assert paths(found) == ["main.osc", *(f"workshop/{name}" for name in ITS_FILES)]


def test_a_missing_model_is_reported_with_its_position(tmp_path: Path) -> None:
    text = "import osc.sim\nscenario main:\n    do spawn_entity('crate', 'file:///crate.sdf', pose_3d())\n"
    with pytest.raises(UsageError, match="file not found: /crate") as caught:
        bundle(write(tmp_path / "main.osc", text))
    assert caught.value.span is not None


@pytest.mark.parametrize("what", ["missing", "empty"])
def test_empty_and_missing_folders_are_refused(tmp_path: Path, what: str) -> None:
    (tmp_path / "empty").mkdir()
    simulator = Simulator(name="mujoco", model_path=[tmp_path / what])
    with pytest.raises(UsageError, match=what):
        bundle(write(tmp_path / "main.osc"), Options(simulator=simulator))
