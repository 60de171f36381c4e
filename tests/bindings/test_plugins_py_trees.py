"""Action classes on the published `scenario-execution` and `py_trees`, in an environment of their own."""

import site
import subprocess
import sys
from pathlib import Path

import pytest

import seoro
from tests.installed_packages import add_entry_points

pytestmark = pytest.mark.more

LIBRARY = """import osc.types

actor lamp:
    var state: string = 'off'

action blink:
    times: int
    mood: string = 'calm'

action lamp.switch:
    state: string

action count_twice

action endless
"""
PYTHON = """import py_trees
from py_trees.common import Status
from scenario_execution.actions.base_action import ActionError, BaseAction
from scenario_execution.actions.base_action_subtree import BaseActionSubtree


class Blink(BaseAction):
    def __init__(self, times: int):
        super().__init__()
        if times < 0:
            raise ActionError("negative times", action=None)
        self.times = times

    def setup(self, **kwargs):
        self.clock = kwargs["clock"]

    def execute(self, mood: str):
        self.logger.info(f"{self.name} is {mood}")

    def update(self) -> Status:
        self.times -= 1
        self.feedback_message = f"{self.times} left at {self.clock.now():.1f}"
        return Status.RUNNING if self.times else Status.SUCCESS

    def shutdown(self):
        self.logger.info("blink is shut down")


class Switch(BaseAction):
    def execute(self, associated_actor, state: str):
        self.old, self.new = self.get_associated_actor_variable("state"), state

    def update(self) -> Status:
        self.set_associated_actor_variable("state", self.new)
        self.logger.info(f"{self.old} becomes {self.new}")
        return Status.SUCCESS


class CountTwice(BaseActionSubtree):
    def create_subtree(self):
        for name in ("first", "second"):
            self.add_child(py_trees.behaviours.TickCounter(name, 2, Status.SUCCESS))


class Endless(BaseAction):
    def update(self) -> Status:
        return Status.RUNNING

    def request_cancel(self) -> bool:
        self.logger.info("cancel is requested")
        return True

    def shutdown(self):
        self.logger.info("endless is shut down")
"""
SCENARIO = """import osc.helpers
import osc.lights

scenario main:
    red: lamp
    do serial:
        one: blink(3)
        red.switch('on')
        wait red.state == 'on'
        count_twice()
        one_of:
            endless()
            wait elapsed(1s)
        blink(-1)
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Interpreter of an environment with seoro, the published package, and a package with the library `lights`."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True, timeout=300)
    found = folder / "bin/python"
    command = [str(found), "-m", "pip", "install", "-q", "--retries", "0", "scenario-execution==1.8.0"]
    try:
        installed = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    except subprocess.TimeoutExpired:
        pytest.skip("`pip install scenario-execution` takes too long here")
    if installed.returncode:
        pytest.skip(f"scenario-execution cannot be installed: {installed.stderr.strip().splitlines()[-1]}")
    packages = next(folder.glob("lib/python*/site-packages"))
    shared = [str(Path(seoro.__file__).parents[1]), *site.getsitepackages()]
    (packages / "shared.pth").write_text("\n".join(shared) + "\n")
    (packages / "sx_lights/lib_osc").mkdir(parents=True)
    (packages / "sx_lights/lib_osc/lights.osc").write_text(LIBRARY)
    (packages / "sx_lights/__init__.py").write_text("def library():\n    return 'sx_lights', 'lights.osc'\n")
    (packages / "sx_lights/acts.py").write_text(PYTHON)
    add_entry_points(
        packages,
        "sx-lights",
        "[scenario_execution.osc_libraries]\nlights = sx_lights:library\n[scenario_execution.actions]\n"
        "blink = sx_lights.acts:Blink\nlamp.switch = sx_lights.acts:Switch\n"
        "count_twice = sx_lights.acts:CountTwice\nendless = sx_lights.acts:Endless\n",
    )
    return found


def test_their_classes_run_unchanged(python: Path, tmp_path: Path) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    code = "from seoro.cli.main import main; raise SystemExit(main(['exec', 'main.osc', '--clock', 'virtual']))"
    done = subprocess.run(
        [str(python), "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False
    )
    lines = [line.strip() for line in done.stdout.splitlines()]
    assert done.returncode == 1, done.stderr
    assert "`blink` failed: negative times" in done.stderr
    expected = [
        "0.000 s    one is calm",
        "0.000 s    2 left at 0.0",
        "0.100 s    1 left at 0.1",
        "0.200 s    0 left at 0.2",
        "0.200 s    off becomes on",
        "1.600 s    cancel is requested",
        "1.600 s    endless is shut down",
        "1.600 s    blink is shut down",
    ]
    assert [line for line in lines if line in expected] == expected
