"""Names of the ROS 2 nodes of bridges and their guards."""

from __future__ import annotations

from typing import Final

BRIDGE: Final = "seoro_bridge"
GUARD: Final = "seoro_guard"
