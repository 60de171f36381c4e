"""Which links of an arm can collide with each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from defusedxml import ElementTree

NEAR = 2  # moving joints between links that are shaped to go free of each other, or overlap where they are joined


def colliding_pairs(urdf: str) -> tuple[tuple[str, str], ...]:
    """Pairs of links with shapes that are more than `NEAR` moving joints apart."""
    robot = ElementTree.fromstring(urdf)
    parents = {}
    for joint in robot.iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link", "")] = (parent.get("link", ""), joint.get("type") != "fixed")
    solid = [link.get("name", "") for link in robot.findall("link") if link.find("collision") is not None]
    depths = {link: _depths(link, parents) for link in solid}
    return tuple(
        (first, second) for first, second in combinations(solid, 2) if _apart(depths[first], depths[second]) > NEAR
    )


def joint_counts(urdf: str, joints: Sequence[str]) -> dict[str, int]:
    """How many of the joints of an arm, in order from its base, move each of the links that they move."""
    counts: dict[str, int] = {}
    ends = {}
    for joint in ElementTree.fromstring(urdf).iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            ends[child.get("link", "")] = (parent.get("link", ""), joint.get("name", ""))
    for link in ends:
        above = link
        while above in ends:
            above, joint_name = ends[above]
            if joint_name in joints:
                counts[link] = joints.index(joint_name) + 1
                break
    return counts


def _depths(link: str, parents: dict[str, tuple[str, bool]]) -> dict[str, int]:
    """How many moving joints lie between a link and each of those that it hangs on, itself among them."""
    depths, joints = {link: 0}, 0
    while link in parents:
        link, moves = parents[link]
        joints += moves
        depths[link] = joints
    return depths


def _apart(first: dict[str, int], second: dict[str, int]) -> int:
    """Moving joints on the way from one link to another."""
    return min(depth + second[link] for link, depth in first.items() if link in second)


def hand(urdf: str, fingers: tuple[str, ...]) -> frozenset[str]:
    """The fingers of a gripper, and the links that they slide on."""
    joints = ElementTree.fromstring(urdf).findall("joint")
    ends = [(joint.find("parent"), joint.find("child")) for joint in joints]
    palms = {
        parent.get("link", "")
        for parent, child in ends
        if parent is not None and child is not None and child.get("link") in fingers
    }
    return frozenset(fingers) | palms
