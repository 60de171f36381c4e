"""Links that joints move: the velocities of their points, and the pose of the base that carries them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.manipulation.chain import Chain, joints_above, pose_matrix
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import RobotDeclaration


def base_in_map(engine: Engine, robot: str) -> Array:
    """Return the present pose of a robot's base in `map`, shape (4, 4)."""
    state = engine.body_state(robot)
    return pose_matrix(state.position, rotation_matrix(state.orientation))


class MovedLinks:
    """Links of a robot that position-controlled joints move.

    Args:
        robot: Declaration of the robot.
        joints: Names of the joints.
    """

    def __init__(self, robot: RobotDeclaration, joints: Sequence[str]) -> None:
        self._robot, self._joints = robot, joints
        self._chain = cache(self._chain_to)

    def _chain_to(self, link: str) -> tuple[Chain, list[int]] | None:
        """Return the chain from the base to the last of the joints above a link, and their indices."""
        names, end = joints_above(self._robot.urdf, link, self._joints)
        if not names:
            return None
        chain = Chain(self._robot.urdf, self._robot.base_link, end, names)
        return chain, [self._joints.index(name) for name in names]

    def velocity_at(self, link: str, positions: Array, rates: Array, point: Array) -> Array:
        """Return the velocity of a point of a link relative to the base [m/s], shape (3,).

        Args:
            link: Name of the link.
            point: Point in the base [m], shape (3,).
            positions: Positions of the joints [rad], [m], perhaps followed by others.
            rates: Velocities of the joints [rad/s], [m/s], perhaps followed by others.
        """
        found = self._chain(link)
        if found is None:
            return 0.0 * point
        chain, indices = found
        return chain.velocity_at(positions[indices], rates[indices], len(indices), point)
