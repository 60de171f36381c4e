from __future__ import annotations

import math
import sys
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from seoro.bridges import wire
from sim_nodes.check.drives import drive_of
from sim_nodes.codec import CodecError, pack, unpack
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.navigator import Phase
from sim_nodes.physics import BodyModel, Box, Part
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.worlds.loader import load_world

VALUES: tuple[Any, ...] = (
    None,
    True,
    -7,
    2**70,
    1e-320,
    -0.0,
    math.inf,
    "text",
    b"bytes",
    [1, [2]],
    (1, (2,), ()),
    {"a": 1, 2: "b", ("c", "d"): None},
    {1, 2},
    frozenset({("a", "b")}),
    deque([1, 2], maxlen=5),
    Pose2(1.0, 2.0, 3.0),
    Phase.ALIGN,
    Goal("g", (Pose2(0.0, 0.0, 0.0),), True),
    BodyModel((Part(Box((1.0, 2.0, 3.0))),), static=True),
    wire.Occurrence(id="x", time=1.0, outcome=wire.Outcome.ABORTED),
    np.float64(0.1),
)


@pytest.mark.parametrize("value", VALUES, ids=repr)
def test_decoding_returns_equal_values(value: object) -> None:
    back = unpack(pack(value))
    assert type(back) is type(value)
    assert repr(back) == repr(value)
    assert back == value


@pytest.mark.parametrize("dtype", ["float64", "int8", "bool", "uint16", "complex128"])
def test_decoded_arrays_keep_type_and_shape_and_are_writable(dtype: str) -> None:
    array = np.arange(12).reshape(3, 4).astype(dtype)
    back = unpack(pack({"array": array.T}))["array"]
    assert (back.dtype, back.shape) == (array.dtype, (4, 3))
    assert np.array_equal(back, array.T)
    back[0, 0] = 1


def test_not_a_number_is_decoded() -> None:
    assert math.isnan(unpack(pack(math.nan)))
    assert np.isnan(unpack(pack(np.array([np.nan])))).all()


def test_a_world_is_decoded() -> None:
    world = load_world("maze")
    assert unpack(pack(world)) == world


class Open:
    pass


@dataclass
class Changing:
    value: int


@pytest.mark.parametrize("value", [Open(), Changing(1), lambda: 1, [{"deep": Open}], np.array([Open()]), {1, "a"}])
def test_unsupported_types_are_refused(value: object) -> None:
    with pytest.raises(CodecError):
        pack(value)


def record(name: str, fields: dict[str, object]) -> bytes:
    packed: bytes = msgpack.packb(msgpack.ExtType(6, msgpack.packb([name, fields])))
    return packed


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        pack([1, 2])[:-1],
        pack(Pose2(1.0, 2.0, 3.0))[:-3],
        record("sim_nodes.geometry:Pose2", {"x": 1.0}),
        record("sim_nodes.geometry:wrap", {"angle": 1.0}),
        record("sim_nodes.simulation:Simulation", {}),
        record("pathlib:Path", {}),
        record("sim_nodes.geometry:Nothing", {}),
        record("sim_nodes.run_plot:np.ndarray", {}),
        record("os:system", {"command": "true"}),
        msgpack.packb(msgpack.ExtType(5, msgpack.packb(["O", [1], b"12345678"]))),
        msgpack.packb(msgpack.ExtType(5, msgpack.packb(["<f8", [3], b"12345678"]))),
        msgpack.packb(msgpack.ExtType(77, b"")),
    ],
    ids=repr,
)
def test_invalid_bytes_are_refused(data: bytes) -> None:
    with pytest.raises(CodecError):
        unpack(data)


def test_decoding_imports_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "sim_nodes.sdf", raising=False)
    with pytest.raises(CodecError, match=r"unknown frozen data|unsupported type"):
        unpack(record("sim_nodes.sdf:Model", {}))
    assert "sim_nodes.sdf" not in sys.modules


def test_derived_values_of_models_are_left_out() -> None:
    drive = drive_of(DriveKind.ACKERMANN)
    assert drive.steered  # computed once, and kept
    assert unpack(pack(drive)) == drive
