"""The package of ROS 2 in `ros2/`: colcon builds it, and `ros2` runs scenarios with it where that is installed."""

import ast
import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import seoro
from seoro.cli.main import main

PACKAGE = Path(__file__).parents[2] / "ros2" / "seoro"
SCENARIO = """import osc.helpers
scenario hello:
    do serial:
        log("hello")
        {end}
"""


def test_the_package_has_the_version_of_the_project() -> None:
    assert ET.parse(PACKAGE / "package.xml").findtext("version") == seoro.__version__


def test_arguments_of_launch_files_are_options_of_exec(capsys: pytest.CaptureFixture[str]) -> None:
    text = (PACKAGE / "launch" / "scenario.launch.py").read_text()
    assigned = [each for each in ast.parse(text).body if isinstance(each, ast.Assign)]
    (options,) = (ast.literal_eval(each.value) for each in assigned if ast.unparse(each.targets[0]) == "OPTIONS")
    with pytest.raises(SystemExit):
        main(["exec", "--help"])
    described = capsys.readouterr().out
    missing = [option for option, _ in options.values() if f"{option} " not in described]
    assert not missing


def test_the_launch_file_of_executors_has_options_of_its_commands(capsys: pytest.CaptureFixture[str]) -> None:
    text = (PACKAGE / "launch" / "executor.launch.py").read_text()
    options = set(re.findall(r'"(--[a-z-]+)"', text))
    assert options == {"--name", "--listen", "--on", "--executor", "--ros", "--node"}
    described = ""
    for command in (["serve"], ["ros", "serve"]):
        with pytest.raises(SystemExit):
            main([*command, "--help"])
        described += capsys.readouterr().out
    assert not [option for option in options if f"{option} " not in described]


@pytest.fixture(scope="module")
def prefix(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a workspace with the built package."""
    if shutil.which("colcon", path=SYSTEM) is None or not Path("/usr/share/ament_cmake").exists():
        pytest.skip("no colcon or ament_cmake; `.ci/run` names the packages of Debian")
    workspace = tmp_path_factory.mktemp("workspace")
    command = ["colcon", "build", "--base-paths", str(PACKAGE)]
    subprocess.run(command, cwd=workspace, env={"PATH": SYSTEM, "HOME": str(workspace)}, check=True, timeout=300)
    return workspace / "install"


SYSTEM = "/usr/bin:/bin"  # programs of Debian, which need its Python


@pytest.mark.more
def test_colcon_installs_launch_files_and_the_command(prefix: Path) -> None:
    share = prefix / "seoro" / "share"
    assert (share / "ament_index" / "resource_index" / "packages" / "seoro").is_file()
    assert (share / "seoro" / "launch" / "scenario.launch.py").is_file()
    assert (share / "seoro" / "launch" / "executor.launch.py").is_file()
    assert (share / "seoro" / "test" / "scenario.test.py").is_file()
    assert os.access(prefix / "seoro" / "lib" / "seoro" / "seoro", os.X_OK)


@pytest.mark.more
@pytest.mark.parametrize(("end", "status"), [("emit end", 0), ("emit fail", 1)])
def test_ros2_runs_scenarios(prefix: Path, tmp_path: Path, end: str, status: int) -> None:
    """The verdict is the result of `ros2 test`; `ros2 launch` shows it."""
    if shutil.which("ros2") is None:
        pytest.skip("no ros2 command: launch files were not tried")
    (tmp_path / "hello.osc").write_text(SCENARIO.format(end=end))
    arguments = "scenario:=hello.osc ros:=none seed:=7"
    test = prefix / "seoro" / "share" / "seoro" / "test" / "scenario.test.py"
    for command, expected in (
        (f"ros2 launch seoro scenario.launch.py {arguments}", 0),
        (f"ros2 test {test} {arguments}", status),
    ):
        done = subprocess.run(
            ["sh", "-c", f". {prefix}/local_setup.sh && {command}"],
            cwd=tmp_path,
            env={**os.environ, "COLCON_CURRENT_PREFIX": str(prefix)},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        shown = done.stdout + done.stderr
        assert done.returncode == expected, shown
        assert "seed 7" in shown and ("failed: `emit fail`" in shown) == bool(status)
