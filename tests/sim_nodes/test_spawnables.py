"""Models for spawning: files on the model path, props of the world, and files in given folders."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import files
from sim_nodes.simulator import Simulator
from tests.sim_nodes.client import BOX, Client, pose
from tests.sim_nodes.engines import make_engine

OWN = ("example_simulation://models/box.sdf", "manipulation://cube.sdf")
WORLD = """
name: yard
extent: [-5, -5, 5, 5]
props:
  - {name: parcel, box: [0.2, 0.4, 0.6], mass: 2.0, pose: {x: 2.0, y: 0.0}}
  - {name: post, cylinder: {radius: 0.1, length: 1.0}, pose: {x: -2.0, y: 0.0}}
"""


@pytest.fixture
def yard(tmp_path: Path) -> Client:
    (tmp_path / "yard.yaml").write_text(WORLD)
    mine = tmp_path / "models" / "garden" / "pots"
    mine.mkdir(parents=True)
    (mine / "small pot.sdf").write_text(BOX)
    (mine / "wrong.sdf").write_text("nonsense")
    (mine / "notes.txt").write_text(BOX)
    client = Client(str(tmp_path / "yard.yaml"))
    client.simulator = Simulator(
        make_engine("mujoco"), str(tmp_path / "yard.yaml"), 0, ModelPath([tmp_path / "models"])
    )
    return client


def found(client: Client, *sources: str) -> wire.Spawnables:
    return client.ask(wire.GET_SPAWNABLES, wire.GetSpawnables(sources=sources))


def spawn(client: Client, name: str, uri: str) -> wire.EntityBounds:
    request = wire.SpawnEntity(name=name, uri=uri, initial_pose=pose(0.0, 2.0, z=0.5))
    client.ask(wire.SPAWN_ENTITY, request)
    return client.ask(wire.GET_ENTITY_BOUNDS, wire.EntityName(name=name))


def test_props_and_models_of_the_model_path_are_listed(yard: Client) -> None:
    listed = found(yard)
    uris = tuple(each.uri for each in listed.spawnables)
    assert uris == ("prop://parcel", "prop://post", "garden://pots/small%20pot.sdf", *OWN)
    assert listed.message == ""
    parcel, post, pot, *_ = listed.spawnables
    assert (parcel.description, post.description, pot.description) == (
        "prop parcel of the world, 2 kg",
        "prop post of the world, fixed",
        "small pot.sdf, 5 kg",
    )
    assert (pot.bounds.lower.x, pot.bounds.upper.z) == (-0.15, 0.3)


def test_listed_models_can_be_spawned_by_their_uri(yard: Client) -> None:
    for index, each in enumerate(found(yard).spawnables):
        bounds = spawn(yard, f"thing_{index}", each.uri).bounds
        assert bounds == each.bounds
        yard.ask(wire.DELETE_ENTITY, wire.EntityName(name=f"thing_{index}"))


def test_models_in_given_folders_are_listed(yard: Client, tmp_path: Path) -> None:
    folder = tmp_path / "more"
    folder.mkdir()
    (folder / "box.sdf").write_text(BOX)
    (folder / "away.sdf").symlink_to(tmp_path / "models" / "garden" / "pots" / "small pot.sdf")
    named = found(yard, folder.as_uri(), "relative", str(tmp_path / "none"))
    assert named.spawnables[-1].uri == f"file://{folder.resolve()}/box.sdf"
    assert named.message == f"folder not found: 'relative'; folder not found: '{tmp_path}/none'"
    spawn(yard, "box", named.spawnables[-1].uri)


def test_a_truncated_list_is_reported(yard: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MAX_FILES", 2)
    listed = found(yard)
    assert [each.uri for each in listed.spawnables[2:]] == ["garden://pots/small%20pot.sdf"]
    assert listed.message == "ignored further files after the first 2"


@pytest.mark.parametrize(
    ("uri", "words"),
    [
        ("", "missing model"),
        ("prop://moon", "prop://moon: unknown prop 'moon' of the world; props: parcel, post"),
        ("garden://pots/none.sdf", "unknown model 'garden://pots/none.sdf' (searched:"),
        ("box.sdf", "invalid model 'box.sdf': expected `name://path`"),
    ],
)
def test_unknown_models_are_refused(yard: Client, uri: str, words: str) -> None:
    with pytest.raises(RequestRefused) as refused:
        spawn(yard, "thing", uri)
    assert words in refused.value.message
    assert refused.value.code == wire.SpawnResult.NO_RESOURCE
