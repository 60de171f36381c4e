"""Arms and grippers of surveyed robots."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.ros2.adoption.draft import CHECK, Draft, Question
from seoro.bridges.ros2.adoption.survey import Survey
from seoro.bridges.ros2.urdf import REVOLUTE, Joint, Links
from seoro.bridges.ros2.wire import Endpoint
from seoro.files.commented_yaml import Place

ARM: Final = "arm"
GRIPPER: Final = (ARM, "gripper")
CAUTIOUS: Final = 0.5  # [rad/s]
WIDEST: Final = 0.085  # [m]
FORCE: Final = 40.0  # [N]
_FINGERS: Final = ("finger", "knuckle", "gripper")  # in names of joints
_TOOLS: Final = ("tool0", "tcp", "tool", "ee_link", "hand", "flange")  # in names of frames, the most usual first
_DESCRIBED: Final = "of robot_description"

log = logging.getLogger(__name__)


def draft_arm(draft: Draft, survey: Survey) -> bool:
    """Draft the arm of a robot; return False if the names of its joints are unknown."""
    robot = survey.robot
    ranked = sorted(robot.parts["trajectory"], key=lambda each: -len(_controlled(survey, each)))
    action, joints = ranked[0], _controlled(survey, ranked[0]) or _reported(survey)
    if not joints:
        draft.remarks.append(f"{CHECK}: {action.name} moves an arm, but the names of its joints are not visible")
        return False
    others = dict.fromkeys(each.name for each in ranked if each.name != action.name)
    source = "parameter of its controller" if _controlled(survey, action) else "of joint_states"
    _draft_joints(draft, joints, survey.links, source)
    also = f"; also found: {', '.join(others)}" if others else ""
    draft.put((ARM, "trajectory"), robot.relative(action.name), f"found: {action.name}, {action.type}{also}")
    if "joint_states" in robot:
        draft.put((ARM, "joint_states"), robot.relative(robot.name("joint_states")))
    _draft_frames(draft, joints, survey.links)
    if "move_group" in robot:
        draft.put((ARM, "move_group", "action"), robot.relative(robot.name("move_group")))
        _draft_group(draft, joints, survey)
    if "gripper" in robot:
        _draft_gripper(draft, survey)
    return True


def _controlled(survey: Survey, action: Endpoint) -> list[str]:
    """Return the joints of the controller of an action, by its parameter `joints`."""
    known = {} if action.node is None else survey.parameters.get(action.node.full_name, {})
    return [str(each) for each in known.get("joints", ())]


def _reported(survey: Survey) -> list[str]:
    """Return the joints of the joint states that may be those of an arm: neither wheels nor fingers."""
    message = survey.message("joint_states")
    names = [] if message is None else [str(name) for name in message.name]
    return [name for name in names if not any(word in name for word in ("wheel", "caster", *_FINGERS))]


def _finger_states(survey: Survey) -> list[str]:
    """Return the joints of the joint states that may be those of a gripper."""
    message = survey.message("joint_states")
    names = [] if message is None else [str(name) for name in message.name]
    return [name for name in names if any(word in name for word in _FINGERS)]


def _draft_joints(draft: Draft, joints: Sequence[str], links: Links | None, source: str) -> None:
    known = {} if links is None else {joint.name: joint for joint in links.joints}
    place = (ARM, "joints")
    unknown: list[Place] = []
    for name in joints:
        joint = known.get(name)
        if joint is None or not 0.0 < joint.speed < math.inf:
            unknown.append((*place, name))
            draft.put((*place, name), CAUTIOUS)
        else:
            draft.put((*place, name), round(joint.speed, 4))
        if joint is not None and joint.limits is not None:
            draft.put((ARM, "limits", name), [round(side, 4) for side in joint.limits])
    speeds = "" if len(unknown) == len(joints) else f"; speeds {_DESCRIBED}"
    if unknown:
        text = f"maximum speed of {', '.join(each[-1] for each in unknown)} [rad/s]"
        draft.add(Question(text, CAUTIOUS, lambda speed: dict.fromkeys(unknown, speed), (*place, unknown[0][-1])))
    draft.notes[place] = f"names: {source}{speeds}"


def _draft_frames(draft: Draft, joints: Sequence[str], links: Links | None) -> None:
    chain = () if links is None else [joint for joint in links.joints if joint.name in joints]
    if links is None or not chain:
        return
    above = {joint.child: joint for joint in links.joints}
    children = {joint.child for joint in chain}
    first = next(joint for joint in chain if joint.parent not in children)
    base = first.parent
    while not base.endswith("base_link") and base in above and not above[base].moves:
        base = above[base].parent
    if not base.endswith("base_link"):
        base = first.parent
    draft.put((ARM, "base_frame"), base, _DESCRIBED)
    last = next(
        (joint for joint in reversed(chain) if joint.child not in {each.parent for each in chain}), chain[-1]
    )
    rigid = _rigid_links(links, last.child)
    tool = next((link for word in _TOOLS for link in rigid if word in link), last.child)
    draft.put((ARM, "tool"), tool, f"{_DESCRIBED}; fixed to the last joint: {', '.join(rigid)}")


def _rigid_links(links: Links, link: str) -> list[str]:
    """Return the links that are fixed to a link, itself first."""
    found = [link]
    for each in found:  # grows
        found += [joint.child for joint in links.joints if joint.parent == each and not joint.moves]
    return found


def _draft_group(draft: Draft, joints: Sequence[str], survey: Survey) -> None:
    place = (ARM, "move_group", "group")
    message = survey.message("semantics")
    groups = {} if message is None else _groups(message.data, survey.links)
    fitting = [name for name, members in groups.items() if set(joints) <= members]
    if fitting:
        best = min(fitting, key=lambda name: len(groups[name]))
        draft.put(place, best, f"of robot_description_semantic; groups: {', '.join(groups)}")
    else:
        draft.ask("planning group of MoveIt for the arm", next(iter(groups), "manipulator"), place)


def _groups(srdf: str, links: Links | None) -> dict[str, set[str]]:
    """Return the joints of the planning groups of an SRDF, by the names of the groups."""
    try:
        root = ElementTree.fromstring(srdf)
    except (ElementTree.ParseError, DefusedXmlException) as error:
        log.warning("unreadable robot_description_semantic: %s", error)
        return {}
    above = {} if links is None else {joint.child: joint for joint in links.joints}
    groups: dict[str, set[str]] = {}
    for group in root.findall("group"):
        joints = groups.setdefault(group.get("name", ""), set())
        joints |= {joint.get("name", "") for joint in group.findall("joint")}
        for chain in group.findall("chain"):
            link, seen = chain.get("tip_link", ""), set[str]()
            while link in above and link != chain.get("base_link") and link not in seen:
                seen.add(link)
                joints.add(above[link].name)
                link = above[link].parent
    return {name: members for name, members in groups.items() if name}


# ------------------------------------------------------------------------------------------------ grippers


def _draft_gripper(draft: Draft, survey: Survey) -> None:
    robot, known = survey.robot, survey.parameters_of("gripper")
    draft.put((*GRIPPER, "action"), robot.relative(robot.name("gripper")))
    links = () if survey.links is None else survey.links.joints
    fingers = [joint for joint in links if joint.moves and any(word in joint.name for word in _FINGERS)]
    leading = [joint for joint in fingers if not joint.mimics]
    name = known.get("joint")
    joint = next((each for each in leading if name in (None, each.name)), None)
    if isinstance(name, str):
        draft.put((*GRIPPER, "joint"), name, "parameter of its controller")
    elif joint is not None:
        draft.put((*GRIPPER, "joint"), joint.name, f"{_DESCRIBED}, by its name")
    elif moving := _finger_states(survey):
        draft.put((*GRIPPER, "joint"), moving[0], "of joint_states, by its name")
    else:
        draft.ask("joint of the gripper", "gripper_joint", (*GRIPPER, "joint"))
    _draft_travel(draft, joint, fingers)
    force = known.get("max_effort")
    if isinstance(force, float) and 0.0 < force < math.inf:
        draft.put((*GRIPPER, "force"), force, "parameter of its controller")
    else:
        draft.ask("force of the gripper [N]", FORCE, (*GRIPPER, "force"))


def _draft_travel(draft: Draft, joint: Joint | None, fingers: Sequence[Joint]) -> None:
    """Draft positions of the gripper from the limits of its joint."""
    if joint is None or joint.limits is None:
        draft.ask("position of the closed gripper [rad, m]", 0.0, (*GRIPPER, "closed"))
        draft.ask("travel of its joint per metre of opening [rad/m, m/m]", 1.0, (*GRIPPER, "per_metre"))
        draft.ask("maximum opening [m]", WIDEST, (*GRIPPER, "widest"))
        return
    lowest, highest = joint.limits
    if joint.kind in REVOLUTE:
        closed, opened = sorted((lowest, highest), key=lambda side: -abs(side))

        def fill(widest: float) -> Mapping[Place, Any]:
            slope = round((opened - closed) / widest, 6)
            return {(*GRIPPER, "per_metre"): slope, (*GRIPPER, "widest"): widest}

        draft.put((*GRIPPER, "closed"), closed, f"guessed: the end of the limits of '{joint.name}' away from zero")
        draft.add(Question("maximum opening of the gripper [m]", WIDEST, fill))
        return
    has_twin = any(each.mimics == joint.name for each in fingers)
    share = 0.5 if has_twin else 1.0
    note = f"guessed from the limits of '{joint.name}'{', which another finger mimics' if has_twin else ''}"
    draft.put((*GRIPPER, "closed"), lowest, note)
    draft.put((*GRIPPER, "per_metre"), share, note)
    draft.put((*GRIPPER, "widest"), round((highest - lowest) / share, 6), note)
