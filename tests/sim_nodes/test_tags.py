"""Descriptions and tags of entities: set by `set_entity_info`, in world files, and when spawning."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Category, EntityFilter, FilterMode, ResetScope, TagsFilter
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import BOX, ROBOT, Client, pose

WORLD = """
name: yard
extent: [-5, -5, 5, 5]
walls:
  - {points: [[-4, -4], [4, -4]], tags: [brick]}
  - {points: [[-4, 4], [4, 4]], tags: [brick, north]}
robots:
  - {name: turtlebot4, robot: turtlebot4, tags: [fleet, small]}
props:
  - {name: parcel, cube: 0.2, mass: 1.0, pose: {x: 2.0, y: 0.0}, tags: [cargo, small]}
cameras:
  - {name: eye, position: [0, 0, 2], look_at: [0, 0.1, 0], tags: [fleet]}
"""


@pytest.fixture
def yard(tmp_path: Path) -> Client:
    (tmp_path / "yard.yaml").write_text(WORLD)
    return Client(str(tmp_path / "yard.yaml"))


def found(client: Client, *tags: str, mode: int = FilterMode.ANY, **of: object) -> tuple[str, ...]:
    wanted = EntityFilter.model_validate({"tags": TagsFilter(tags=tags, filter_mode=mode), **of})
    names = client.ask(wire.GET_ENTITIES, wanted).names
    assert client.ask(wire.GET_ENTITIES_STATES, wanted).names == names
    return names


def info(client: Client, name: str) -> wire.EntityInfo:
    return client.ask(wire.GET_ENTITY_INFO, wire.EntityName(name=name))


def describe(client: Client, name: str, category: int, description: str, *tags: str) -> None:
    reported = wire.EntityInfo(category=category, description=description, tags=tags)
    client.ask(wire.SET_ENTITY_INFO, wire.SetEntityInfo(name=name, info=reported))


def spawn(client: Client, name: str, *tags: str) -> None:
    request = wire.SpawnEntity(
        name=name, uri="box.sdf", resource_string=BOX, initial_pose=pose(-2.0, 1.0, z=0.1), tags=tags
    )
    client.ask(wire.SPAWN_ENTITY, request)


def test_entities_of_a_world_are_found_by_any_or_all_of_their_tags(yard: Client) -> None:
    assert found(yard) == ("eye", "parcel", ROBOT, "walls")
    assert found(yard, "small") == ("parcel", ROBOT)
    assert found(yard, "small", "brick") == ("parcel", ROBOT, "walls")
    assert found(yard, "small", "fleet", mode=FilterMode.ALL) == (ROBOT,)
    assert found(yard, "fleet", categories=(Category.OBJECT,)) == ("eye",)
    assert found(yard, "nothing") == ()
    assert info(yard, "walls").tags == ("brick", "north")


def test_an_empty_filter_matches_all(yard: Client) -> None:
    assert found(yard, filter="") == found(yard)


def test_spawned_bodies_have_the_requested_tags(yard: Client) -> None:
    spawn(yard, "box", "cargo")
    assert found(yard, "cargo") == ("box", "parcel")
    assert info(yard, "box") == wire.EntityInfo(
        category=Category.DYNAMIC_OBJECT, description="spawned at 0.000 s", tags=("cargo",)
    )


def test_setting_entity_info_replaces_all_of_it(yard: Client) -> None:
    describe(yard, "parcel", Category.HUMAN, "a visitor", "guest")
    assert info(yard, "parcel") == wire.EntityInfo(
        category=Category.HUMAN, description="a visitor", tags=("guest",)
    )
    assert found(yard, "cargo") == ()
    assert found(yard, categories=(Category.HUMAN,)) == ("parcel",)
    describe(yard, "parcel", Category.OBJECT, "")
    assert info(yard, "parcel") == wire.EntityInfo(category=Category.OBJECT, description="")


def test_entity_info_lasts_until_deletion_or_a_full_reset(yard: Client) -> None:
    spawn(yard, "box", "cargo")
    describe(yard, "box", Category.OBJECT, "a box", "mine")
    describe(yard, ROBOT, Category.ROBOT, "an old one", "mine")
    yard.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=ResetScope.SPAWNED))
    assert found(yard, "mine") == (ROBOT,)
    spawn(yard, "box", "cargo")
    assert info(yard, "box").tags == ("cargo",)
    describe(yard, "box", Category.OBJECT, "a box", "mine")
    yard.ask(wire.DELETE_ENTITY, wire.EntityName(name="box"))
    spawn(yard, "box")
    assert info(yard, "box").tags == ()
    yard.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
    assert info(yard, ROBOT).tags == ("fleet", "small")


def test_snapshots_keep_entity_info(yard: Client) -> None:
    spawn(yard, "box", "cargo")
    describe(yard, ROBOT, Category.ROBOT, "an old one", "mine")
    resumed = Client(yard.ask(wire.SAVE_STATE, wire.Empty()), None)
    assert found(resumed, "mine", "cargo", "north") == ("box", "parcel", ROBOT, "walls")
    assert info(resumed, ROBOT).description == "an old one"


def test_invalid_requests_are_refused(yard: Client) -> None:
    with pytest.raises(RequestRefused, match="unknown entity 'moon'"):
        describe(yard, "moon", Category.OBJECT, "")
    with pytest.raises(RequestRefused, match=r"unknown category 3; categories: 0 \(object\)"):
        describe(yard, ROBOT, 3, "")
    with pytest.raises(RequestRefused, match="the description has 1001 characters; expected at most 1000"):
        describe(yard, ROBOT, Category.ROBOT, "x" * 1001)
    with pytest.raises(RequestRefused, match="invalid tag 'two words'; expected 1 to 64 characters"):
        describe(yard, ROBOT, Category.ROBOT, "", "two words")
    with pytest.raises(RequestRefused, match="found 21 tags; expected at most 20"):
        describe(yard, ROBOT, Category.ROBOT, "", *(f"t{number}" for number in range(21)))
    with pytest.raises(RequestRefused, match="invalid tag ''"):
        spawn(yard, "box", "")
    with pytest.raises(RequestRefused, match=r"unknown filter mode 7; expected 0 \(any of the tags\) or 1 \(all"):
        found(yard, "small", mode=7)
    assert info(yard, ROBOT).tags == ("fleet", "small")
