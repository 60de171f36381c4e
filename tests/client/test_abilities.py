"""What older executors cannot do is said, before they are sent what they would not understand."""

from typing import Any, cast

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bundle.packing import Bundle
from seoro.client.abilities import check_ability
from seoro.errors import InvalidUse

FILM = {"width": 64, "height": 48, "rate": 1}


def executor(minor: int) -> Executor:
    return Executor(cast("Any", None), "lab-a", minor)


def bundle(names_absolute: bool = False, **given: Any) -> Bundle:
    options = wire.BundledOptions.model_validate({"grace": 5.0, "overrides": {}, **given})
    file = wire.BundleFile(path="main.osc", hash="0" * 64, size=1)
    return Bundle(
        wire.Manifest(files=(file,), entry="main.osc", shown="main.osc", options=options), {}, names_absolute
    )


@pytest.mark.parametrize(
    ("minor", "given", "asked", "message"),
    [
        (0, {}, {"priority": 3}, "knows no priorities"),
        (1, {"simulator": {"name": "mujoco", "rate": 1.0, "world_file": "a.yaml"}}, {}, "takes no world files"),
        (2, {"simulator": {"name": "ros", "rate": 1.0}}, {}, "uses no simulators of ROS 2 systems"),
        (2, {"simulator": {"endpoint": "tcp/127.0.0.1:1", "rate": 1.0}, "film": FILM}, {}, "records no films"),
        (2, {"names_absolute": True}, {}, "does not find files by absolute paths"),
        (2, {}, {"is_dry": True}, "makes no dry runs"),
    ],
)
async def test_what_it_is_too_old_for_is_told(
    minor: int, given: dict[str, Any], asked: dict[str, Any], message: str
) -> None:
    with pytest.raises(InvalidUse, match=f"the executor 'lab-a' is older than this seoro .*, and {message}"):
        await check_ability(executor(minor), bundle(**given), **asked)
    await check_ability(executor(minor + 1), bundle(**given), **asked)
