"""Optional parts of `Engine`. An engine declares missing parts by base classes, whose methods raise:

    class ToyEngine(WithoutDynamics, WithoutArms, WithoutRendering, WithoutTerrain):

`sim_nodes.check` skips the rules for those parts. Saving states has no such class: see `SavesState`.
"""

from __future__ import annotations

from typing import Any, NoReturn

from sim_nodes.views import NoRendering


class WithoutDynamics:
    """Bodies stay where they are put and nothing is pushed; robots with wheels move as their wheels turn."""


class WithoutArms:
    """The engine has no joints except wheels; worlds with arms are refused."""

    name: str

    def _refuse(self, *_arguments: Any, **_named: Any) -> NoReturn:
        raise NotImplementedError(f"the engine {self.name} does not support arms")

    joint_states = command_joints = command_fingers = link_contacts = arm_overlaps = _refuse


class WithoutRendering:
    """The engine does not render; cameras give no images."""

    name: str

    def _refuse(self, *_arguments: Any, **_named: Any) -> NoReturn:
        raise NoRendering(f"the engine {self.name} does not render images")

    link_pose = render = _refuse


class WithoutTerrain:
    """The floor is flat; worlds with terrain are refused."""
