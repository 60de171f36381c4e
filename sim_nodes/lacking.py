"""What engines may do without. An engine says so by its base classes, which refuse in its place:

    class ToyEngine(WithoutDynamics, WithoutArms, WithoutPictures):

`sim_nodes.check` leaves out the rules for that. To save no state it takes no base class: see `SavesState`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

from sim_nodes.geometry import Array, Quaternion, Vector
from sim_nodes.physics import Carried, JointStates, Overlap
from sim_nodes.views import NoRendering, Picture, View


class WithoutDynamics:
    """Bodies stay where they are put, and nothing is pushed; robots that drive move as their wheels turn."""


class WithoutArms:
    """There are no joints but wheels; worlds with arms are refused."""

    name: str

    def joint_states(self, robot: str) -> JointStates:
        """Refused."""
        self._refuse()

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """Refused."""
        self._refuse()

    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """Refused."""
        self._refuse()

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """Refused."""
        self._refuse()

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: Carried | None
    ) -> tuple[Overlap, ...]:
        """Refused."""
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise NotImplementedError(f"the engine {self.name} has no arms, and loads no worlds with arms")


class WithoutPictures:
    """Cameras see nothing, and say so."""

    name: str

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """Refused."""
        raise NoRendering(f"the engine {self.name} draws no pictures")

    def render(self, view: View) -> Picture:
        """Refused."""
        raise NoRendering(f"the engine {self.name} draws no pictures")
