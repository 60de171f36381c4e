from __future__ import annotations

import subprocess
import sys

MODULES = ("node", "simulation", "verbs", "__main__", "check")
CORE = "".join(f"import sim_nodes.{name}; " for name in MODULES) + "import sys; "


def test_the_core_imports_no_engine_and_no_plotting() -> None:
    check = CORE + "sys.exit(', '.join({'mujoco', 'pybullet', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=False, timeout=60)
    assert done.stderr.strip() == ""
