"""Forward kinematics of an arm from its URDF.

Poses are homogeneous (4, 4) matrices: `pose_a_in_b` transforms points from frame a to frame b. A configuration is
an array of the positions of the arm's joints, in the order of its declaration: [rad] of joints that turn,
[m] of sliding ones.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from itertools import combinations, takewhile
from xml.etree.ElementTree import Element

import numpy as np
import numpy.typing as npt
from defusedxml import ElementTree

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.models.urdf import read_origin
from sim_nodes.models.xml_reading import vector

Flags = npt.NDArray[np.bool_]
LIMITS = ("lower", "upper", "velocity")  # attributes of a URDF
SLIDING = "prismatic"  # type of joints in URDF
NEAR = 2  # movable joints between links that never collide, or overlap by design


@dataclass(frozen=True)
class Limits:
    """Limits of the joints of an arm, each of shape (n,)."""

    lower: Array  # [rad], [m]
    upper: Array
    speed: Array  # [rad/s], [m/s]
    slides: Flags  # whether it slides instead of turning

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the positions."""
        return tuple("m" if slides else "rad" for slides in self.slides)


@dataclass(frozen=True)
class _Link:
    """A movable joint, with the fixed joints before it."""

    mount: Array  # pose of the joint at zero in the frame of the joint before it
    axis: Array  # unit vector in the joint's frame
    slides: bool = False  # along the axis, instead of turning about it

    def moved(self, position: float) -> Array:
        """Return its motion from zero to a position [rad], [m], shape (4, 4)."""
        if not self.slides:
            return _turn(self.axis, position)
        return pose_matrix(position * self.axis, np.eye(3))

    def all_moved(self, positions: Array) -> Array:
        """Return its motions to positions of shape (m,), shape (m, 4, 4)."""
        if not self.slides:
            return _turns(self.axis, positions)
        motions = np.tile(np.eye(4), (len(positions), 1, 1))
        motions[:, :3, 3] = positions[:, None] * self.axis
        return motions


class Chain:
    """Kinematic chain from the base of an arm to its tool.

    Args:
        urdf: Text of the URDF.
        base_link: First link.
        tool_link: Last link.
        joints: Names of the movable joints between them, in order.

    Raises:
        ValueError: The URDF has other joints between the links, or they neither turn nor slide.
    """

    def __init__(self, urdf: str, base_link: str, tool_link: str, joints: Sequence[str]) -> None:
        way = _joints_between(ElementTree.fromstring(urdf), base_link, tool_link)
        moving = [joint for joint in way if joint.get("type") != "fixed"]
        found = [joint.get("name", "") for joint in moving]
        if found != list(joints):
            raise ValueError(f"found joints {found} from {base_link} to {tool_link}; expected {list(joints)}")
        if any(joint.get("type") not in ("revolute", SLIDING) for joint in moving):
            raise ValueError(f"expected only revolute and prismatic joints from {base_link} to {tool_link}")
        self.joints = tuple(joints)
        self.limits = _limits(moving)
        self._links, self._tool = _links(way)

    def tool_pose(self, configuration: Array) -> Array:
        """Return the pose of the tool in the base, shape (4, 4)."""
        return self._frames(configuration)[-1]

    def jacobian(self, configuration: Array) -> tuple[Array, Array]:
        """Return the pose of the tool in the base, and its Jacobian.

        Returns:
            The pose, shape (4, 4), and the Jacobian, shape (6, n). Rows 0 to 2 are the velocity of the tool's
            origin [m/rad], [m/m], rows 3 to 5 its angular velocity, both in the base's frame.
        """
        frames = self._frames(configuration)
        tool = frames[-1]
        axes = np.array([frame[:3, :3] @ link.axis for frame, link in zip(frames[:-1], self._links, strict=True)])
        arms = tool[:3, 3] - np.array([frame[:3, 3] for frame in frames[:-1]])
        slides = self.limits.slides[:, None]
        return tool, np.vstack([np.where(slides, axes, np.cross(axes, arms)).T, np.where(slides, 0.0, axes).T])

    def jacobians(self, configurations: Array) -> tuple[Array, Array]:
        """Return the results of `jacobian` for configurations: shapes (m, 4, 4) and (m, 6, n), from (m, n)."""
        count = len(configurations)
        pose = np.broadcast_to(np.eye(4), (count, 4, 4))
        axes, origins = [], []
        for link, angles in zip(self._links, configurations.T, strict=True):
            pose = pose @ link.mount @ link.all_moved(angles)
            axes.append(pose[:, :3, :3] @ link.axis)
            origins.append(pose[:, :3, 3])
        tool = pose @ self._tool
        arms = tool[:, None, :3, 3] - np.stack(origins, axis=1)
        along, slides = np.stack(axes, axis=1), self.limits.slides[:, None]
        columns = [np.where(slides, along, np.cross(along, arms)), np.where(slides, 0.0, along)]
        return tool, np.concatenate(columns, axis=2).transpose(0, 2, 1)

    @property
    def shoulder(self) -> Array:
        """Origin of the first joint at zero in the base [m], shape (3,)."""
        return self._links[0].mount[:3, 3]

    @property
    def reach(self) -> float:
        """Distance from the shoulder to the tool of the stretched arm [m], the maximum."""
        mounts = [link.mount for link in self._links[1:]]
        strokes = np.maximum(np.abs(self.limits.lower), np.abs(self.limits.upper))[self.limits.slides]
        return float(sum(np.linalg.norm(mount[:3, 3]) for mount in (*mounts, self._tool))) + float(strokes.sum())

    def velocity_at(self, configuration: Array, rates: Array, count: int, point: Array) -> Array:
        """Return the velocity of a point of a link in the base [m/s].

        Args:
            configuration: Positions of the joints [rad], [m]; later elements are ignored, also in `rates`.
            rates: Velocities of the joints [rad/s], [m/s].
            count: Number of joints between the base and the link.
            point: Point in the base [m].
        """
        velocity = np.zeros(3)
        frames = self._frames(configuration[: len(self._links)])
        for frame, link, rate in zip(frames[:count], self._links, rates, strict=False):
            axis = frame[:3, :3] @ link.axis
            velocity += rate * (axis if link.slides else np.cross(axis, point - frame[:3, 3]))
        return velocity

    def _frames(self, configuration: Array) -> list[Array]:
        """Return the poses of the joints at a configuration, and of the tool, in the base."""
        pose, frames = np.eye(4), []
        for link, position in zip(self._links, configuration, strict=True):
            pose = pose @ link.mount @ link.moved(float(position))
            frames.append(pose)
        return [*frames, pose @ self._tool]


def pose_matrix(position: Sequence[float] | Array, rotation: Array) -> Array:
    """Return the pose with a position [m] and a (3, 3) rotation matrix."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def inverse(pose: Array) -> Array:
    """Return the inverse pose."""
    turn = pose[:3, :3].T
    return pose_matrix(-turn @ pose[:3, 3], turn)


def _turn(axis: Array, angle: float) -> Array:
    """Return the rotation about a unit vector by Rodrigues' formula."""
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
    """Return the rotations about a unit vector, shape (m, 4, 4)."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turns = np.zeros((len(angles), 4, 4))
    turns[:, 3, 3] = 1.0
    sin, rest = np.sin(angles)[:, None, None], 1.0 - np.cos(angles)[:, None, None]
    turns[:, :3, :3] = np.eye(3) + sin * cross + rest * (cross @ cross)
    return turns


def _joints_between(robot: Element, base_link: str, tool_link: str) -> list[Element]:
    """Return the joints from base to tool, in order."""
    above = _joints_above(tool_link, _parent_joints(robot))
    way = list(takewhile(lambda joint: _end(joint, "child") != base_link, above))
    top = _end(way[-1], "parent") if way else tool_link
    if top != base_link:
        raise ValueError(f"no joints lead from {base_link} to {tool_link}: {top} has no parent joint")
    return way[::-1]


def _end(joint: Element, which: str) -> str:
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _links(way: list[Element]) -> tuple[list[_Link], Array]:
    """Return the movable joints, and the pose of the tool in the last of them."""
    links, mount = [], np.eye(4)
    for joint in way:
        position, orientation = read_origin(joint)
        mount = mount @ pose_matrix(position, rotation_matrix(orientation))
        if joint.get("type") != "fixed":
            links.append(_Link(mount, _axis(joint), joint.get("type") == SLIDING))
            mount = np.eye(4)
    return links, mount


def _axis(joint: Element) -> Array:
    found = joint.find("axis")
    axis: Array = np.array(vector("1 0 0" if found is None else found.get("xyz", "1 0 0"), "axis of a joint"))
    unit: Array = axis / np.linalg.norm(axis)
    return unit


def inner_joints(urdf: str, base_link: str, tool_link: str) -> list[str]:
    """Return the names of the movable joints from a link to another one, in order.

    Raises:
        ValueError: No joints lead from one to the other.
    """
    way = _joints_between(ElementTree.fromstring(urdf), base_link, tool_link)
    return [joint.get("name", "") for joint in way if joint.get("type") != "fixed"]


def joint_limits(urdf: str, joints: Sequence[str]) -> Limits:
    """Return the limits of joints that turn or slide, in their order.

    Raises:
        ValueError: A joint is unknown, of another type, or without limits.
    """
    known = {joint.get("name", ""): joint for joint in ElementTree.fromstring(urdf).iter("joint")}
    unknown = [name for name in joints if name not in known]
    if unknown:
        raise ValueError(f"unknown joint {unknown[0]!r}; the URDF has {', '.join(known)}")
    for name in joints:
        if known[name].get("type") not in ("revolute", SLIDING):
            raise ValueError(
                f"joint {name} has type {known[name].get('type')!r}; expected 'revolute' or 'prismatic'"
            )
    return _limits([known[name] for name in joints])


def _limits(moving: list[Element]) -> Limits:
    for joint in moving:
        if joint.find("limit") is None:
            raise ValueError(f"missing limits of joint {joint.get('name')}")
    found = [joint.findall("limit")[0] for joint in moving]
    values = np.array([[float(limit.get(key, "nan")) for limit in found] for key in LIMITS])
    if not np.isfinite(values).all():
        raise ValueError("missing limit `lower`, `upper` or `velocity` of a joint")
    lower, upper, speed = values
    return Limits(lower, upper, speed, np.array([joint.get("type") == SLIDING for joint in moving]))


def colliding_pairs(urdf: str) -> tuple[tuple[str, str], ...]:
    """Return the pairs of links with shapes that are more than `NEAR` movable joints apart."""
    robot = ElementTree.fromstring(urdf)
    parents = _parent_joints(robot)
    solid = [link.get("name", "") for link in robot.findall("link") if link.find("collision") is not None]
    depths = {link: _depths(link, parents) for link in solid}
    return tuple(
        (first, second) for first, second in combinations(solid, 2) if _apart(depths[first], depths[second]) > NEAR
    )


def joints_above(urdf: str, link: str, joints: Container[str]) -> tuple[list[str], str]:
    """Return those of some joints that move a link, in order from the base, and the child of the last of them."""
    above = _joints_above(link, _parent_joints(ElementTree.fromstring(urdf)))
    found = [joint for joint in above if joint.get("name", "") in joints]
    names = [joint.get("name", "") for joint in reversed(found)]
    return names, _end(found[0], "child") if found else link


def gripper_links(urdf: str, fingers: tuple[str, ...]) -> frozenset[str]:
    """Return the fingers of a gripper and the links that they slide on."""
    parents = _parent_joints(ElementTree.fromstring(urdf))
    return frozenset(fingers) | {_end(parents[finger], "parent") for finger in fingers if finger in parents}


def _parent_joints(robot: Element) -> dict[str, Element]:
    """Return the joint above each link except the base."""
    return {child: joint for joint in robot.iter("joint") if (child := _end(joint, "child"))}


def _joints_above(link: str, parents: Mapping[str, Element]) -> Iterator[Element]:
    """Yield the joints between a link and the base, from the link."""
    while link in parents:
        yield parents[link]
        link = _end(parents[link], "parent")


def _depths(link: str, parents: Mapping[str, Element]) -> dict[str, int]:
    """Return the number of movable joints between a link and each of its ancestors, including itself."""
    depths, joints = {link: 0}, 0
    for joint in _joints_above(link, parents):
        joints += joint.get("type") != "fixed"
        depths[_end(joint, "parent")] = joints
    return depths


def _apart(first: Mapping[str, int], second: Mapping[str, int]) -> int:
    """Return the number of movable joints between two links."""
    return min(depth + second[link] for link, depth in first.items() if link in second)
