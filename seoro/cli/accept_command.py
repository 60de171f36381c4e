"""`seoro accept`: check a recorded trace, or a ROS 2 bag, against a scenario."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count, write_errors
from seoro.cli.output import print_reason
from seoro.cli.packages import ROS2, require
from seoro.cli.terminal import use_colour
from seoro.cli.trace_input import read_records
from seoro.embed import accept, load
from seoro.embed import run as run_scenario
from seoro.errors import UsageError
from seoro.files.replacing import replacing
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.render import render_text
from seoro.runtime.accept import Acceptance, Unchecked, Violation
from seoro.runtime.execution.outputs import TRACE
from seoro.runtime.trace.jsonl import to_line
from seoro.runtime.verdict import RunStatus
from seoro.traces.reader import Record

EXAMPLES = """examples:
  seoro exec maze.osc --clock virtual --trace trace.jsonl
  seoro accept trace.jsonl maze.osc
  seoro accept --json trace.jsonl maze.osc
  seoro accept field/drive monitor.osc         # a bag: what happened satisfies a scenario that only observes

exit status: 0 accepted, 1 not accepted, 2 the command line, the trace, the bag or the scenario is invalid"""

_CODE = "E0530"
_BAGS = (".mcap", ".db3")
_MAX_SHOWN = 50  # violations, and things not checked, on the terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "recorded",
        metavar="TRACE",
        help="trace of `seoro exec --trace`, or ROS 2 bag (folder, .mcap or .db3); - for stdin",
    )
    parser.add_argument("file", metavar="SCENARIO", help="scenario file (.osc) of the run, or to observe the bag")
    add_option(parser, "--trace FILE", "with a bag: write the trace of the observation, for `seoro report`")
    add_option(parser, "--json", "print the result as one JSON object on stdout")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    if _is_bag(options.recorded):
        return _accept_bag(options)
    if options.trace is not None:
        raise UsageError("`--trace` needs a bag", help="leave it out: the trace exists already")
    records = read_records(options.recorded)
    acceptance = accept(load(options.file), records)
    if options.json:
        print(json.dumps(acceptance.plain(), ensure_ascii=False, indent=1))
    else:
        _show(acceptance, records)
    return Exit.PASSED if acceptance.accepted else Exit.FAILED


class _Kept:
    """Records of a run."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def record(self, record: Record) -> None:
        """Keep a record."""
        self.records.append(record)


def _is_bag(name: str) -> bool:
    path = Path(name)
    return path.suffix in _BAGS or (path.is_dir() and not (path / TRACE).exists())


def _accept_bag(options: argparse.Namespace) -> int:
    """Run the scenario as an observer of a bag."""
    require("`seoro accept` of a bag", "ros2", *ROS2)
    kept = _Kept()
    observers = [kept] if options.trace is not None else []
    verdict = run_scenario(load(options.file), bag=options.recorded, observers=observers)
    if options.trace is not None:
        with write_errors(options.trace), replacing(options.trace) as partial:
            partial.write_bytes(b"".join(map(to_line, kept.records)))
    accepted = verdict.status is RunStatus.PASSED
    if options.json:
        found = {"accepted": accepted, "reason": verdict.reason, "duration": verdict.duration}
        print(json.dumps(found, ensure_ascii=False, indent=1))
    elif accepted:
        print(f"accepted: {options.recorded}, after {verdict.duration:.3f} s of the bag")
    else:
        print_reason(verdict)
        print(f"not accepted: {options.recorded}, after {verdict.duration:.3f} s of the bag", file=sys.stderr)
    return Exit.of_run(verdict.status)


def _show(acceptance: Acceptance, records: list[Record]) -> None:
    """Print violations on stderr, everything else on stdout."""
    colour = use_colour(sys.stderr)
    for violation in acceptance.violations[:_MAX_SHOWN]:
        print(_violation(violation, records, colour=colour) + "\n", file=sys.stderr)
    hidden = len(acceptance.violations) - _MAX_SHOWN
    if hidden > 0:
        print(f"and {count(hidden, 'more violation')} (`--json` lists all)", file=sys.stderr)
    for unchecked in acceptance.unchecked[:_MAX_SHOWN]:
        print(_unchecked(unchecked))
    hidden = len(acceptance.unchecked) - _MAX_SHOWN
    if hidden > 0:
        print(f"and {hidden} more parts not checked (`--json` lists all)")
    what = count(acceptance.records, "record")
    if acceptance.accepted:
        print(f"accepted: {what}" + (", apart from the parts not checked" if acceptance.unchecked else ""))
    else:
        print(f"not accepted: {what}, {count(len(acceptance.violations), 'violation')}", file=sys.stderr)


def _violation(violation: Violation, records: list[Record], *, colour: bool) -> str:
    """Format a violation with the scenario's text and the records that prove it."""
    message = f"{violation.message} ({violation.rule.title}, {violation.rule.section})"
    shown = ", ".join(_record(record) for record in records if record.get("seq") in violation.records)
    hint = f"see {shown}" if shown else ""
    if violation.span is None:
        return f"error[{_CODE}]: {message}" + (f"\n  = help: {hint}" if hint else "")
    found = Diagnostic(Severity.ERROR, _CODE, message, Label(violation.span, ""), help=hint)
    return render_text(found, colour=colour)


def _record(record: Record) -> str:
    return f"record {record.get('seq')} ({record.get('kind')} at {record.get('t')} s)"


def _unchecked(unchecked: Unchecked) -> str:
    where = f"{unchecked.span}: " if unchecked.span is not None else ""
    times = f" ({unchecked.count} times)" if unchecked.count > 1 else ""
    rule = f"{unchecked.rule.title}, {unchecked.rule.section}"
    return f"not checked: {where}{unchecked.reason}{times} ({rule})"
