from __future__ import annotations

import subprocess
import sys

CORE = "import sim_nodes.node, sim_nodes.simulation, sim_nodes.verbs, sim_nodes.__main__; import sys; "


def test_the_core_knows_no_engine_and_pictures_are_not_loaded_before_they_are_asked_for() -> None:
    check = CORE + "sys.exit(', '.join({'mujoco', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.strip() == ""
