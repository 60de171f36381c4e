"""How the nodes are called by which bridges take part in ROS 2 systems, for those who look for nodes of robots."""

from __future__ import annotations

from typing import Final

BRIDGE: Final = "seoro_bridge"
GUARD: Final = "seoro_guard"
