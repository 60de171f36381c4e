"""What can be spawned."""

from __future__ import annotations

from seoro.bridges.wire.filters import Bounds
from seoro.bridges.wire.message import Message, Verb


class GetSpawnables(Message):
    """Which models can be spawned by their `uri` alone.

    A node looks along its own model path, and among the props of its world; `sources` are folders besides, on the
    machine of the node, each by its path or as `file://PATH`.
    """

    sources: tuple[str, ...] = ()


class Spawnable(Message):
    """A model by its `uri`: what it is, for people, and how far it reaches along its own axes."""

    uri: str
    description: str
    bounds: Bounds


class Spawnables(Message):
    """Models that can be spawned; `message` names sources that are none, and says where the list ends early."""

    spawnables: tuple[Spawnable, ...]
    message: str = ""


GET_SPAWNABLES = Verb("get_spawnables", GetSpawnables, Spawnables)
