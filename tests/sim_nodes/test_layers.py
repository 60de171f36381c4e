from __future__ import annotations

import os
import subprocess
import sys

import pytest

from sim_nodes.__main__ import ENGINES

MODULES = ("node", "simulation", "verbs", "__main__", "check")
CORE = "".join(f"import sim_nodes.{name}; " for name in MODULES) + "import sys; "


def test_the_core_imports_no_engine_and_no_plotting() -> None:
    check = CORE + "sys.exit(', '.join({'mujoco', 'pybullet', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.strip() == ""


@pytest.mark.parametrize("engine", [pytest.param(name, marks=pytest.mark.engine(name)) for name in ENGINES])
def test_a_node_starts_without_libraries_for_pictures_meshes_and_statistics(engine: str) -> None:
    heavy = {"glfw", "matplotlib", "OpenGL", "PIL", "scipy", "skimage", "trimesh", "av"}
    start = f"from sim_nodes.simulator import Simulator; Simulator(main.ENGINES[{engine!r}](), 'maze', 0); "
    check = (
        "import sys; import sim_nodes.__main__ as main; "
        + start
        + f"sys.exit(', '.join({heavy} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.strip() == ""


def test_a_node_has_no_threads_for_large_matrices() -> None:
    check = (
        "import os, runpy, sys; sys.argv = ['sim_nodes', '--help']\n"
        "try: runpy.run_module('sim_nodes', run_name='__main__')\n"
        "except SystemExit: pass\n"
        "import scipy.linalg\n"
        "sys.exit(len(os.listdir('/proc/self/task')) - 1)"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    command = [sys.executable, "-c", check]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, env=environment)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.more
def test_a_robot_navigates_around_a_box_without_scipy() -> None:
    check = (
        "import sys; from tests.sim_nodes.client import Client, pose\n"
        "client = Client('empty'); client.localise()\n"
        "client.spawn('box', pose(0.8, 0.0)); client.navigate(pose(1.6, 0.0)); client.run_until('goal')\n"
        "assert len(client.simulator.simulation.robot('turtlebot4').mobile.obstacles.points)\n"
        "sys.exit(', '.join({'scipy', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.strip() == ""
