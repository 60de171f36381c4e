"""Action classes that use rclpy themselves: seoro gives them a node, as scenario_execution does."""

from __future__ import annotations

import site
import subprocess
from pathlib import Path

import anyio
import pytest

import seoro
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.installed_packages import add_entry_points

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

PYTHON = """import rclpy
from std_msgs.msg import String


class Echo:
    received = None
    feedback_message = ""

    def setup(self, **kwargs):
        self.node = kwargs["node"]
        self.said = self.node.create_publisher(String, "said", 10)
        self.subscription = self.node.create_subscription(String, "said", self.receive, 10)

    def execute(self, word):
        self.word = word

    def receive(self, message):
        self.received = message.data

    def update(self):
        self.said.publish(String(data=self.word))
        if self.received != self.word:
            return "RUNNING"
        self.feedback_message = f"{self.node.get_name()} received {self.received}"
        return "SUCCESS"

    def shutdown(self):
        self.node.destroy_subscription(self.subscription)
        print("rclpy is", "up" if rclpy.ok() else "down", flush=True)
"""
SCENARIO = """import osc.helpers
import osc.echoes

scenario main:
    timeout(60s)
    do parallel:
        echo('red')
        echo('blue')
"""
CODE = """import sys
sys.path += {paths!r}
from seoro.cli.main import main
raise SystemExit(main(["exec", "main.osc"]))
"""


@pytest.mark.parametrize("router", ["zenoh 1.8.0"], indirect=True)
async def test_classes_share_a_node_until_the_end_of_the_run(ros2: Ros2, router: str, tmp_path: Path) -> None:
    package = tmp_path / "site/sx_echo"
    (package / "lib_osc").mkdir(parents=True)
    (package / "lib_osc/echoes.osc").write_text("action echo:\n    word: string\n")
    (package / "__init__.py").write_text("def library():\n    return 'sx_echo', 'echoes.osc'\n")
    (package / "acts.py").write_text(PYTHON)
    add_entry_points(
        package.parent,
        "sx-echo",
        "[scenario_execution.osc_libraries]\nechoes = sx_echo:library\n"
        "[scenario_execution.actions]\necho = sx_echo.acts:Echo\n",
    )
    (tmp_path / "main.osc").write_text(SCENARIO)
    paths = [str(package.parent), str(Path(seoro.__file__).parents[1]), *site.getsitepackages()]
    command = [str(ros2.folder / "run"), "-c", CODE.format(paths=paths)]
    with anyio.fail_after(DEADLINE):
        done = await anyio.run_process(
            command, cwd=tmp_path, env={"ROUTER": router}, stderr=subprocess.STDOUT, check=False
        )
    printed = done.stdout.decode()
    assert done.returncode == 0, printed
    assert "seoro_actions received red" in printed
    assert "seoro_actions received blue" in printed
    assert printed.count("rclpy is up") == 2
    assert "already registered" not in printed  # one node for all
