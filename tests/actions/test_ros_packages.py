"""The method of the struct `ament` in `osc.ros`."""

import os
from pathlib import Path

import pytest

from seoro import UsageError
from tests.runtime.conftest import Prepare, RunText

SCENARIO = "import osc.ros\nscenario main:\n    a: ament\n    x: string = a.get_package_share_directory('{}')\n"


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two places of ROS packages, the second of which has `turtle`."""
    index = tmp_path / "second/share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "turtle").write_text("")
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join([str(tmp_path / "first"), str(tmp_path / "second")]))
    return tmp_path


async def test_a_package_is_found_in_all_folders(run_text: RunText, workspace: Path) -> None:
    ran = await run_text(SCENARIO.format("turtle") + "    do log(x)\n")
    assert ran.logs == [(0.0, str(workspace / "second/share/turtle"))]


@pytest.mark.parametrize(
    ("package", "message"),
    [("hare", "unknown ROS 2 package 'hare'; searched in .*first"), ("../turtle", "invalid package name")],
)
async def test_a_missing_package_is_reported(
    package: str, message: str, prepare_text: Prepare, workspace: Path
) -> None:
    with pytest.raises(UsageError, match=message):
        async with prepare_text(SCENARIO.format(package)):
            pass


async def test_a_missing_environment_is_reported(prepare_text: Prepare, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(UsageError, match="ROS 2 not found: `AMENT_PREFIX_PATH` is not set"):
        async with prepare_text(SCENARIO.format("turtle")):
            pass
