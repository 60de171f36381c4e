"""Missing abilities of older executors are reported before a submission."""

from typing import Any, cast

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import Executor
from seoro.bundle.pack import Bundle
from seoro.client.sending import check_ability
from seoro.errors import UsageError

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
        (0, {}, {"priority": 3}, "priorities"),
        (1, {"simulator": {"name": "mujoco", "rate": 1.0, "world_file": "a.yaml"}}, {}, "world files"),
        (2, {"simulator": {"name": "ros", "rate": 1.0}}, {}, "simulators of ROS 2 systems"),
        (2, {"simulator": {"endpoint": "tcp/127.0.0.1:1", "rate": 1.0}, "film": FILM}, {}, "video recording"),
        (2, {"names_absolute": True}, {}, "absolute paths of files"),
        (2, {}, {"is_dry": True}, "dry runs"),
    ],
)
async def test_requests_beyond_the_version_of_an_executor_are_refused(
    minor: int, given: dict[str, Any], asked: dict[str, Any], message: str
) -> None:
    with pytest.raises(
        UsageError, match=f"the executor 'lab-a' is older than this seoro .* and does not support {message}"
    ):
        await check_ability(executor(minor), bundle(**given), **asked)
    await check_ability(executor(minor + 1), bundle(**given), **asked)
