"""`seoro ros adopt`: write a lab file and a profile for each robot of a running ROS 2 system."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from seoro.bridges.addresses import BRIDGE, ROS_ROUTER
from seoro.bridges.ros2.adoption.draft import CHECK, Draft, Question, Value
from seoro.bridges.ros2.adoption.drafting import draft_profile
from seoro.bridges.ros2.adoption.finding import MOVED_BY
from seoro.bridges.ros2.adoption.survey import survey, wait_for_robots
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots.parts import PARTS
from seoro.bridges.ros2.robots.profile import Profile
from seoro.bridges.ros2.router_checks import REMEDY, hidden_peers
from seoro.bridges.ros2.wire import resolve_namespace
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.cli.ros.system import connected, lists_nodes
from seoro.errors import UsageError
from seoro.files.commented_yaml import commented_yaml
from seoro.files.replacing import replacing
from seoro.lab.schema import BridgeFile, LabFile, RobotFile
from seoro.text.printable import one_line

LAB: Final = "lab.yaml"
_NODE: Final = "robots"  # name of the bridge in the lab file
_NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,63}")


@dataclass(frozen=True)
class Adopted:
    """A robot with the draft of its profile."""

    name: str
    namespace: str
    draft: Draft

    @property
    def profile(self) -> Profile:
        """Profile by the draft."""
        return Profile.model_validate({**self.draft.values, "model": self.name})

    @property
    def file(self) -> str:
        """Name of the file of the profile."""
        return f"{self.name}.yaml"


async def adopt(options: argparse.Namespace) -> int:
    """Survey the system, ask for missing values, and write the files."""
    folder = Path(options.output)
    _check_absent([folder / LAB], is_forced=options.force)  # before any question
    async with connected(options) as node:
        hidden = await hidden_peers(node.system.session) if lists_nodes(node) else ""
        if hidden:
            print(f"warning: {hidden}: {REMEDY}", file=sys.stderr)
        robots = await _look(node, options.namespace)
    if not options.yes and sys.stdin.isatty():
        robots = _ask_all(robots)
    files = _files(robots, options)
    _check_absent([folder / name for name in files], is_forced=options.force)
    _write(folder, files)
    _report(robots, files, options)
    return Exit.PASSED


async def _look(node: RosNode, namespace: str | None) -> list[Adopted]:
    """Find and survey the robots of a system, or the one of a namespace."""
    found = await wait_for_robots(node)
    if namespace is not None:
        wanted = resolve_namespace(namespace)
        known = ", ".join(robot.namespace for robot in found) or "none"
        found = tuple(robot for robot in found if robot.namespace == wanted)
        if not found:
            raise UsageError(f"no robot in the namespace {wanted}", help=f"namespaces of robots: {known}")
    adopted: list[Adopted] = []
    remarks: list[str] = []
    for robot in found:
        draft = draft_profile(await survey(node, robot))
        if "base" in draft.values or "arm" in draft.values:
            name = _unused(str(draft.values["model"]), [each.name for each in adopted])
            adopted.append(Adopted(name, robot.namespace, draft))
        remarks += draft.remarks
    if found and not adopted:
        raise UsageError(
            f"no robot is described well enough: {'; '.join(remarks)}",
            help="start the publisher of its joint states, or the controller with the parameter `joints`",
        )
    if not adopted:
        moved = ", ".join(PARTS[part].types[0] for part in MOVED_BY)
        raise UsageError(
            f"found {count(len(node.graph.nodes()) - 1, 'node')}, but no robot: nothing accepts {moved}",
            help="start the drivers of the robot; `seoro ros graph` lists the visible nodes. If some are missing, "
            "check domain and router, and restart nodes that were started before their router",
        )
    return adopted


def _unused(name: str, used: Sequence[str]) -> str:
    names = [name, *(f"{name}_{number}" for number in range(2, len(used) + 2)), f"{name}_robot"]
    return next(each for each in names if each not in used and f"{each}.yaml" != LAB)


def _write(folder: Path, files: Mapping[str, str]) -> None:
    with write_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            with replacing(folder / name) as partial:
                partial.write_text(text, encoding="utf-8")


def _check_absent(paths: Sequence[Path], *, is_forced: bool) -> None:
    present = [str(path) for path in paths if path.exists()]
    if present and not is_forced:
        advice = "choose another folder with `-o`, or overwrite them with `--force`"
        raise UsageError(f"existing files: {', '.join(present)}", help=advice)


# --------------------------------------------------------------------------------------------- questions


def _ask_all(robots: Sequence[Adopted]) -> list[Adopted]:
    """Ask the open questions; an empty answer is the default."""
    answered: list[Adopted] = []
    for robot in robots:
        print(f"{robot.name}: Enter accepts the default")
        name = _ask_name(robot.name, [each.name for each in answered])
        for question in tuple(robot.draft.questions):
            answer = _ask(question)
            if answer is not None:
                robot.draft.answer(question, answer)
        answered.append(replace(robot, name=name))
    return answered


def _ask_name(default: str, used: Sequence[str]) -> str:
    while True:
        name = input(f"name of the robot [{default}] ").strip() or default
        if _NAME.fullmatch(name) and name == _unused(name, used):
            return name
        print(f"  invalid or used name '{one_line(name)}': expected lower-case letters, digits and `_`")


def _ask(question: Question) -> Value | None:
    """Return an answer; None for the default."""
    while True:
        text = input(f"{question.text} [{question.default}] ").strip()
        if not text:
            return None
        if isinstance(question.default, str):
            return text
        try:
            number = float(text)
        except ValueError:
            number = 0.0
        if number and abs(number) < float("inf"):
            return number
        print(f"  invalid answer '{one_line(text)}': expected a number, such as {question.default}")


# ------------------------------------------------------------------------------------------------- files


def _files(robots: Sequence[Adopted], options: argparse.Namespace) -> Mapping[str, str]:
    """Return the texts of the files by their names."""
    files = {robot.file: _profile_text(robot, options) for robot in robots}
    return {LAB: _lab_text(robots, options), **files}


def _profile_text(robot: Adopted, options: argparse.Namespace) -> str:
    heading = [
        f"Profile of the robot in the namespace {robot.namespace}, by `seoro ros adopt` from {options.ros}.",
        f"Values marked {CHECK} are not stated by the system: check them before the robot moves.",
        "Hardware such as an emergency stop is not visible; seoro does not replace it.",
        *robot.draft.remarks,
    ]
    return commented_yaml(robot.profile, robot.draft.notes, "\n".join(heading))


def _lab_text(robots: Sequence[Adopted], options: argparse.Namespace) -> str:
    lab = LabFile(
        bridges={_NODE: BridgeFile(connect=options.bridge)},
        robots={
            robot.name: RobotFile.model_validate({"in": _NODE, "as": robot.name, "type": robot.name})
            for robot in robots
        },
    )
    heading = f"Lab of {count(len(robots), 'robot')}, by `seoro ros adopt`. Start its bridge with:\n"
    return commented_yaml(lab, {}, f"{heading}  {_bridge_command(robots, options)}")


def _bridge_command(robots: Sequence[Adopted], options: argparse.Namespace) -> str:
    words = ["seoro", "bridge", "ros2"]
    for robot in robots:
        space = "" if robot.namespace == "/" else f"@{robot.namespace}"
        words += ["--robot", f"{Path(options.output) / robot.file}:{robot.name}{space}"]
    if options.ros != ROS_ROUTER:
        words += ["--ros", options.ros]
    if options.domain:
        words += ["--domain", str(options.domain)]
    if options.bridge != BRIDGE:
        words += ["--listen", options.bridge]
    return shlex.join(words)


def _report(robots: Sequence[Adopted], files: Mapping[str, str], options: argparse.Namespace) -> None:
    folder = Path(options.output)
    for robot in robots:
        parts = " and ".join(part for part in ("base", "arm") if part in robot.draft.values)
        print(f"{robot.name}: {parts} in the namespace {robot.namespace}")
        for remark in robot.draft.remarks:
            print(f"  {one_line(remark)}")
    for name, text in files.items():
        checks = sum(f"{CHECK}:" in line for line in text.splitlines())
        print(f"wrote {folder / name}" + (f" ({count(checks, 'value')} to check)" if checks else ""))
    print("next, in two terminals:")
    print(f"  {_bridge_command(robots, options)}")
    print(f"  seoro doctor --lab {shlex.quote(str(folder / LAB))}")
