"""`seoro accept`: check a recorded trace against its scenario."""

from __future__ import annotations

import argparse
import json
import sys

from seoro.cli.arguments import add_option
from seoro.cli.exit_status import Exit
from seoro.cli.files import count
from seoro.cli.output import use_colour
from seoro.cli.trace_input import read_records
from seoro.embed import accept, load
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.render import render_text
from seoro.runtime.accept import Acceptance, Unchecked, Violation
from seoro.traces.reader import Record

EXAMPLES = """examples:
  seoro exec maze.osc --clock virtual --trace trace.jsonl
  seoro accept trace.jsonl maze.osc
  seoro accept --json trace.jsonl maze.osc

exit status: 0 accepted, 1 not accepted, 2 the command line, the trace or the scenario is invalid"""

_CODE = "E0530"
_MAX_SHOWN = 50  # violations, and things not checked, on the terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("trace", metavar="TRACE", help="trace of `seoro exec --trace`; - for stdin")
    parser.add_argument("file", metavar="SCENARIO", help="scenario file (.osc) of the run")
    add_option(parser, "--json", "print the result as one JSON object on stdout")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    records = read_records(options.trace)
    acceptance = accept(load(options.file), records)
    if options.json:
        print(json.dumps(acceptance.plain(), ensure_ascii=False, indent=1))
    else:
        _show(acceptance, records)
    return Exit.PASSED if acceptance.accepted else Exit.FAILED


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
