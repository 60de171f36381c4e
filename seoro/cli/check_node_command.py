"""`seoro check-node`: check whether a simulator node or a bridge keeps the rules of the protocol."""

from __future__ import annotations

import argparse
from collections.abc import Awaitable
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING

from seoro.cli.arguments import add_keys_argument, add_option
from seoro.cli.confirmation import confirm
from seoro.cli.exit_status import Exit
from seoro.cli.files import count
from seoro.errors import UsageError
from seoro.runtime.trace.jsonl import to_json
from seoro.text.printable import one_line

if TYPE_CHECKING:
    from seoro.bridges.conformance import Rule

EVERYTHING = "all"

EXAMPLES = """examples:
  seoro check-node tcp/127.0.0.1:7450
  seoro check-node tcp/127.0.0.1:7450 --level drive
  seoro check-node tcp/127.0.0.1:7450 --world empty --json
  seoro check-node tcp/192.168.0.7:7450 --robot tb1 --level navigate
  seoro check-node tcp/192.168.0.7:7450 --robot ur1 --level arm --yes

levels of simulators, each with the rules of the one before:
  time      the clock
  drive     a robot that drives, and its true pose
  entities  spawning, moving and deleting entities
  navigate  goals, and watches of positions
  all       everything that the node supports, also cameras, faults, snapshots, people, doors and lifts

The world is a free and level floor. A robot stands at the origin and faces along x.

levels of bridges, with `--robot`:
  hold      holds and refusals; nothing moves (default)
  drive     also drives and cancellations: the robot moves ahead by 15 cm at most
  navigate  also goals near by, and feedback: a localised robot moves 50 cm ahead at most, and back
  arm       `hold`, and motions of the first joint by 0.05 rad (3 degrees), and of the gripper

Before a robot moves, the command asks. A broken rule is shown with its code, the observation and advice.

exit status: 0 if all rules hold, 1 otherwise"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    from seoro.bridges.conformance import BRIDGE_LEVELS, LEVELS  # noqa: PLC0415 - Zenoh, for this command only

    parser.add_argument("endpoint", metavar="ENDPOINT", help="Zenoh endpoint of the node, or of its router")
    parser.add_argument(
        "--level",
        choices=list(dict.fromkeys((*LEVELS, *BRIDGE_LEVELS, EVERYTHING))),
        help="level to check (default: the highest of which a simulator serves all verbs; `hold` of a bridge)",
    )
    add_option(parser, "--node NODE", "name of the node (default: the only one)")
    add_option(parser, "--robot ROBOT", "check a bridge with this robot of it")
    add_option(parser, "--world WORLD", "world to load for each rule (default: that of the node)")
    add_option(parser, "-y --yes", "with --robot: move the robot without asking")
    add_option(parser, "--json", "print a JSON object with all rules and results")
    add_keys_argument(parser)


async def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.robot is not None:
        return await _check_bridge(options)
    from seoro.bridges.conformance import (  # noqa: PLC0415 - Zenoh, for this command only
        BRIDGE_LEVELS,
        LEVELS,
        check_rule,
        checked_contracts,
        highest_level,
        rules_of,
    )
    from seoro.bridges.launch import SimulatorOptions, connect_simulator  # noqa: PLC0415 - the same
    from seoro.bridges.models import ModelPath  # noqa: PLC0415 - the same

    if options.yes:
        raise UsageError("`--yes` is for bridges; expected `--robot` as well")
    if options.level in BRIDGE_LEVELS.keys() - LEVELS.keys():
        raise UsageError(f"`--level {options.level}` is a level of bridges; expected `--robot` as well")
    initial = SimulatorOptions(options.world, 0, ModelPath())
    make = partial(connect_simulator, options.endpoint, initial, options.node, "a check of conformance")
    async with make() as node:
        name, level = node.name, options.level or highest_level(node)
        supported = {contract for contract in checked_contracts() if node.serves(contract)}
        contracts = supported if level == EVERYTHING else set(LEVELS[level])
        missing = sorted({verb for contract in contracts for verb in node.missing_verbs(contract)})
    report = Report(name, level, options.json)
    for verb in missing:
        report.add(Result(f"The node serves the verb `{verb}`.", f"serves_{verb}", "its features lack it"))
    for rule in rules_of(contracts & supported):
        await report.check(rule, check_rule(rule, make))
    return report.finish()


async def _check_bridge(options: argparse.Namespace) -> int:
    """Check a bridge, by the robot that the user names."""
    from seoro.bridges.conformance import (  # noqa: PLC0415 - Zenoh, for this command only
        BRIDGE_LEVELS,
        MOTIONS,
        HeldRobot,
        check_bridge_rule,
    )
    from seoro.bridges.robot.connecting import connect_robots  # noqa: PLC0415 - the same

    level = options.level or next(iter(BRIDGE_LEVELS))
    if level not in BRIDGE_LEVELS:
        raise UsageError(f"invalid `--level {level}` of a bridge; expected {', '.join(BRIDGE_LEVELS)}")
    if options.world is not None:
        raise UsageError("`--world` applies to simulators; omit it with `--robot`")
    if level in MOTIONS and not options.yes:
        question = f"{options.robot} {MOTIONS[level]}. Is the space around it free?"
        confirm(question, needed_by=f"moving {options.robot}", otherwise=f"{options.robot} was not moved")
    async with connect_robots(options.endpoint, "a check of conformance", options.node, (options.robot,)) as node:
        report = Report(node.name, level, options.json)
        held = HeldRobot(node, options.robot, options.endpoint, options.node)
        for rule in BRIDGE_LEVELS[level]:
            await report.check(rule, check_bridge_rule(rule, held))
    return report.finish()


@dataclass(frozen=True)
class Result:
    """Result of a rule.

    Attributes:
        rule: The requirement.
        code: Code of the rule.
        fault: Observation that contradicts it; empty if the rule holds.
        advice: Advice for keeping the rule.
    """

    rule: str
    code: str
    fault: str
    advice: str = ""


class Report:
    """Prints results as they come, or all of them as JSON.

    Args:
        node: Name of the node.
        level: Level of conformance.
        json: Whether to print JSON at the end.
    """

    def __init__(self, node: str, level: str, json: bool) -> None:
        self._node, self._level, self._json = node, level, json
        self._results: list[Result] = []
        if not json:
            print(f"{node}, level `{level}`:", flush=True)

    async def check(self, rule: Rule, checking: Awaitable[None]) -> None:
        """Await the check of a rule, and add its result."""
        from seoro.bridges.conformance import BrokenRule, advice, requirement  # noqa: PLC0415 - Zenoh, as above

        fault = ""
        try:
            await checking
        except BrokenRule as broken:
            fault = broken.fault
        self.add(Result(requirement(rule), rule.__name__, fault, advice(rule) if fault else ""))

    def add(self, result: Result) -> None:
        """Add the result of a rule."""
        self._results.append(result)
        if self._json:
            return
        print(one_line(f"{'BROKEN' if result.fault else 'ok':7} {result.rule}"), flush=True)
        if result.fault:
            print(f"{'':7} But {one_line(result.fault)} [{result.code}]", flush=True)
        if result.advice:
            print(f"{'':7} {one_line(result.advice)}", flush=True)

    def finish(self) -> Exit:
        """Print the summary; returns the exit status."""
        broken = sum(bool(result.fault) for result in self._results)
        if self._json:
            rules = [{**asdict(result), "holds": not result.fault} for result in self._results]
            print(to_json({"node": self._node, "level": self._level, "conforms": not broken, "rules": rules}))
        else:
            verdict = "does not conform" if broken else "conforms"
            print(f"{broken} of {count(len(self._results), 'rule')} broken: {verdict} to level `{self._level}`")
        return Exit.FAILED if broken else Exit.PASSED
