from __future__ import annotations

from sim_nodes.models import parse_model
from sim_nodes.models.cache import ModelCache, key_of
from sim_nodes.models.scenes import SceneBody
from sim_nodes.models.settings import ModelSettings
from sim_nodes.physics import BodyModel, BodyState, Hull, Part
from tests.sim_nodes.client import BOX


def bodies(size: int) -> tuple[SceneBody, ...]:
    model = BodyModel((Part(Hull(bytes(size))),))
    return (SceneBody("a", model, BodyState((0.0, 0.0, 0.0))),)


def test_the_models_used_last_are_kept_up_to_a_size() -> None:
    cache, parsed = ModelCache(100), list[bytes]()

    def get(key: bytes, size: int) -> None:
        def parse() -> tuple[SceneBody, ...]:
            parsed.append(key)
            return bodies(size)

        cache.get(key, parse)

    for key, size in (
        (b"a", 40),
        (b"b", 40),
        (b"a", 40),
        (b"c", 40),
        (b"a", 40),
        (b"b", 40),
        (b"d", 101),
        (b"d", 101),
    ):
        get(key, size)
    assert parsed == [b"a", b"b", b"c", b"b", b"d", b"d"]


def test_keys_depend_on_everything_that_is_read() -> None:
    keys = [
        key_of("a", {}),
        key_of("b", {}),
        key_of("a", {"x": b"1"}),
        key_of("a", {"x": b"2"}),
        key_of("a", {"y": b"1"}),
        key_of("a", {}, True),
    ]
    assert len(set(keys)) == len(keys)
    assert parse_model(BOX) is parse_model(BOX)
    assert parse_model(BOX) is not parse_model(BOX, settings=ModelSettings(static=True))
