"""The common part of controllers that follow the poses of a path."""

from __future__ import annotations

import math

from sim_nodes.navigation.braking import Braking
from sim_nodes.navigation.contracts import Controller, Path, Setup
from sim_nodes.navigation.cover import cover_of

WINDOW = 12  # poses ahead among which the nearest one is searched
LARGEST_VIEW = 300  # poses ahead that are checked


class PoseController(Controller):
    """A controller that moves on from pose to pose.

    Args:
        setup: See `Plugin`.
        name: Its name in messages.
    """

    STATE = ("_index",)

    def __init__(self, setup: Setup, name: str) -> None:
        setup.refuse_parameters(f"controller `{name}`")
        declared = setup.declaration
        self._drive = declared.drive
        self._parameters = p = declared.navigation
        self._known = setup.known
        self._cover = cover_of(declared)
        self._braking = Braking(declared.drive)
        self._top_speed = min(self._drive.max_speed, p.desired_linear_vel or math.inf)
        self._turn_rate = min(p.rotate_to_heading_angular_vel, self._drive.max_turn_rate)
        self._reach = self._cover.reach + self._braking.room(self._top_speed) + p.lookahead_dist
        self.begin()

    def begin(self) -> None:
        """See `Controller.begin`."""
        self._index = 0  # of the pose on the path

    def set_plan(self, path: Path) -> None:
        """See `Controller.set_plan`."""
        self._index = 0
