"""Forward kinematics of an arm, from its URDF.

Poses are homogeneous (4, 4) matrices: `pose_a_in_b` takes points given in frame a to frame b. A configuration is
the positions of the arm's joints [rad], in the order of its declaration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
from defusedxml import ElementTree

from sim_nodes.geometry import Array, Vector, quaternion, rotation_matrix


@dataclass(frozen=True)
class Limits:
    """What the joints of an arm can do, each of shape (n,)."""

    lower: Array  # [rad]
    upper: Array
    speed: Array  # [rad/s]


@dataclass(frozen=True)
class _Link:
    """A joint of the way from base to tool, with the fixed ones before it."""

    mount: Array  # pose of the joint, at zero, in the frame of the joint before it
    axis: Array  # unit vector in the joint's frame


class Chain:
    """The way from the base of an arm to its tool.

    Args:
        urdf: Text of the URDF.
        base_link: Where it begins.
        tool_link: Where it ends.
        joints: Names of the joints that move between the two, in order.

    Raises:
        ValueError: The URDF has other joints on that way, or they are not revolute.
    """

    def __init__(self, urdf: str, base_link: str, tool_link: str, joints: Sequence[str]) -> None:
        way = _way(ElementTree.fromstring(urdf), base_link, tool_link)
        moving = [joint for joint in way if joint.get("type") != "fixed"]
        found = [joint.get("name", "") for joint in moving]
        if found != list(joints):
            raise ValueError(f"the joints from {base_link} to {tool_link} are {found}, not {list(joints)}")
        if any(joint.get("type") != "revolute" for joint in moving):
            raise ValueError(f"all joints from {base_link} to {tool_link} have to be revolute")
        self.joints = tuple(joints)
        self.limits = _limits(moving)
        self._links, self._tool = _links(way)

    def tool_pose(self, configuration: Array) -> Array:
        """The pose of the tool in the base, shape (4, 4)."""
        return self._frames(configuration)[-1]

    def jacobian(self, configuration: Array) -> tuple[Array, Array]:
        """The pose of the tool in the base, and how it moves with the joints.

        Returns:
            The pose, shape (4, 4), and the matrix, shape (6, n): rows 0 to 2 are the velocity of the tool's origin
            [m/rad], rows 3 to 5 its angular velocity, both in the base's frame.
        """
        frames = self._frames(configuration)
        tool = frames[-1]
        axes = np.array([frame[:3, :3] @ link.axis for frame, link in zip(frames[:-1], self._links, strict=True)])
        arms = tool[:3, 3] - np.array([frame[:3, 3] for frame in frames[:-1]])
        return tool, np.vstack([np.cross(axes, arms).T, axes.T])

    def jacobians(self, configurations: Array) -> tuple[Array, Array]:
        """As `jacobian`, of many configurations at once: shapes (m, 4, 4) and (m, 6, n), from (m, n)."""
        count = len(configurations)
        pose = np.broadcast_to(np.eye(4), (count, 4, 4))
        axes, origins = [], []
        for link, angles in zip(self._links, configurations.T, strict=True):
            pose = pose @ link.mount @ _turns(link.axis, angles)
            axes.append(pose[:, :3, :3] @ link.axis)
            origins.append(pose[:, :3, 3])
        tool = pose @ self._tool
        arms = tool[:, None, :3, 3] - np.stack(origins, axis=1)
        turning = np.stack(axes, axis=1)
        return tool, np.concatenate([np.cross(turning, arms), turning], axis=2).transpose(0, 2, 1)

    @property
    def shoulder(self) -> Array:
        """Origin of the first joint in the base [m], which no joint moves; shape (3,)."""
        return self._links[0].mount[:3, 3]

    @property
    def reach(self) -> float:
        """Distance from the shoulder beyond which the tool is in no posture [m]: that of the arm, stretched."""
        mounts = [link.mount for link in self._links[1:]]
        return float(sum(np.linalg.norm(mount[:3, 3]) for mount in (*mounts, self._tool)))

    def velocity_at(self, configuration: Array, rates: Array, count: int, point: Array) -> Array:
        """The velocity of a point of a link, in the base [m/s].

        Args:
            configuration: Positions of the joints [rad]; what follows them is left out, as of `rates`.
            rates: Of the joints [rad/s].
            count: How many of the joints, from the base on, move the link.
            point: In the base [m].
        """
        velocity = np.zeros(3)
        frames = self._frames(configuration[: len(self._links)])
        for frame, link, rate in zip(frames[:count], self._links, rates, strict=False):
            velocity += rate * np.cross(frame[:3, :3] @ link.axis, point - frame[:3, 3])
        return velocity

    def _frames(self, configuration: Array) -> list[Array]:
        """The poses of the joints, turned, and of the tool, in the base."""
        pose, frames = np.eye(4), []
        for link, angle in zip(self._links, configuration, strict=True):
            pose = pose @ link.mount @ _turn(link.axis, float(angle))
            frames.append(pose)
        return [*frames, pose @ self._tool]


def pose_matrix(position: Sequence[float] | Array, rotation: Array) -> Array:
    """The pose with a position [m] and a (3, 3) rotation matrix."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def inverse(pose: Array) -> Array:
    """The pose of the parent in the frame that the pose is of."""
    turn = pose[:3, :3].T
    return pose_matrix(-turn @ pose[:3, 3], turn)


def _turn(axis: Array, angle: float) -> Array:
    """A rotation about a unit vector, by the formula of Rodrigues."""
    x, y, z = axis.tolist()
    cos, sin = math.cos(angle), math.sin(angle)
    rest = 1.0 - cos
    return np.array(
        [
            [cos + x * x * rest, x * y * rest - z * sin, x * z * rest + y * sin, 0.0],
            [y * x * rest + z * sin, cos + y * y * rest, y * z * rest - x * sin, 0.0],
            [z * x * rest - y * sin, z * y * rest + x * sin, cos + z * z * rest, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def _turns(axis: Array, angles: Array) -> Array:
    """Rotations about one unit vector, shape (m, 4, 4)."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turns = np.zeros((len(angles), 4, 4))
    turns[:, 3, 3] = 1.0
    sin, rest = np.sin(angles)[:, None, None], 1.0 - np.cos(angles)[:, None, None]
    turns[:, :3, :3] = np.eye(3) + sin * cross + rest * (cross @ cross)
    return turns


def _way(robot: Element, base_link: str, tool_link: str) -> list[Element]:
    """The joints from base to tool, in order."""
    parents = {_end(joint, "child"): joint for joint in robot.iter("joint")}
    way: list[Element] = []
    link = tool_link
    while link != base_link:
        if link not in parents:
            raise ValueError(f"no joints lead from {base_link} to {tool_link}: nothing holds {link}")
        way.append(parents[link])
        link = _end(parents[link], "parent")
    return way[::-1]


def _end(joint: Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _links(way: list[Element]) -> tuple[list[_Link], Array]:
    """The joints that move, and the pose of the tool in the last of them."""
    links, mount = [], np.eye(4)
    for joint in way:
        mount = mount @ _origin(joint)
        if joint.get("type") != "fixed":
            links.append(_Link(mount, _axis(joint)))
            mount = np.eye(4)
    return links, mount


def _origin(joint: Element) -> Array:
    origin = joint.find("origin")
    if origin is None:
        return np.eye(4)
    roll, pitch, yaw = _vector(origin.get("rpy", "0 0 0"))
    return pose_matrix(_vector(origin.get("xyz", "0 0 0")), rotation_matrix(quaternion(roll, pitch, yaw)))


def _axis(joint: Element) -> Array:
    found = joint.find("axis")
    axis: Array = np.array(_vector("1 0 0" if found is None else found.get("xyz", "1 0 0")))
    unit: Array = axis / np.linalg.norm(axis)
    return unit


def _limits(moving: list[Element]) -> Limits:
    limits = list(_limit_elements(moving))

    def values(key: str) -> Array:
        return np.array([float(limit.get(key, "nan")) for limit in limits])

    found = Limits(values("lower"), values("upper"), values("velocity"))
    if not np.isfinite([found.lower, found.upper, found.speed]).all():
        raise ValueError("a joint lacks the limits `lower`, `upper` or `velocity`")
    return found


def _limit_elements(moving: list[Element]) -> Iterator[Element]:
    for joint in moving:
        limit = joint.find("limit")
        if limit is None:
            raise ValueError(f"the joint {joint.get('name')} has no limits")
        yield limit


def _vector(text: str) -> Vector:
    x, y, z = map(float, text.split())
    return (x, y, z)
