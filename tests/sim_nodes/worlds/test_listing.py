"""Lists of available worlds, with descriptions and tags from their files."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import FilterMode, GetAvailableWorlds, TagsFilter
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import files
from sim_nodes.worlds.loader import available_worlds
from tests.sim_nodes.client import Client

YARD = "name: yard\nextent: [-5, -5, 5, 5]\ndescription: Outside.\ntags: [outdoor, small]\n"


def found(client: Client, *sources: str, tags: tuple[str, ...] = ()) -> wire.AvailableWorlds:
    wanted = TagsFilter(tags=tags, filter_mode=FilterMode.ALL)
    return client.ask(wire.GET_AVAILABLE_WORLDS, GetAvailableWorlds(tags=wanted, sources=sources))


def test_worlds_are_listed_with_descriptions(empty: Client) -> None:
    worlds = found(empty)
    assert worlds.names == available_worlds()
    assert [world.source for world in worlds.worlds] == list(worlds.names)
    assert all(world.description.endswith(".") for world in worlds.worlds)
    current = empty.ask(wire.GET_CURRENT_WORLD, wire.Empty())
    assert current.description in [world.description for world in worlds.worlds]


def test_worlds_of_folders_are_listed_by_paths_that_load_them(empty: Client, tmp_path: Path) -> None:
    (tmp_path / "yards").mkdir()
    (tmp_path / "yards" / "yard.yaml").write_text(YARD)
    (tmp_path / "robot.yaml").write_text("model: cart\n")
    worlds = found(empty, str(tmp_path), "here")
    path = str(tmp_path.resolve() / "yards" / "yard.yaml")
    assert worlds.names == (*available_worlds(), path)
    assert worlds.worlds[-1] == wire.WorldInfo(source=path, description="Outside.", tags=("outdoor", "small"))
    assert worlds.message == "folder not found: 'here'"
    assert empty.ask(wire.LOAD_WORLD, wire.LoadWorld(world=path)).world == "yard"
    assert empty.ask(wire.GET_CURRENT_WORLD, wire.Empty()).tags == ("outdoor", "small")


def test_worlds_are_filtered_by_tags(empty: Client, tmp_path: Path) -> None:
    (tmp_path / "yard.yaml").write_text(YARD)
    assert len(found(empty, str(tmp_path), tags=("small", "outdoor")).names) == 1
    assert found(empty, str(tmp_path), tags=("small", "indoor")).names == ()
    with pytest.raises(RequestRefused, match="invalid tag ''"):
        found(empty, tags=("",))


def test_a_truncated_list_is_reported(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MAX_FILES", 2)
    worlds = found(empty)
    assert worlds.names == available_worlds()[:2]
    assert worlds.message == "ignored further files after the first 2"
