"""`seoro accept`: whether a trace is accepted by a scenario."""

from __future__ import annotations

import argparse
import json
import sys

from seoro.cli.exits import Exit
from seoro.cli.files import count, open_bytes
from seoro.cli.output import use_colour
from seoro.embed import accept, load
from seoro.errors import InvalidUse
from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.render import render_text
from seoro.runtime.accept import Acceptance, Unchecked, Violation
from seoro.traces.read import Record, Unreadable, only_records, read_trace

EXAMPLES = """examples:
  seoro exec maze.osc --clock virtual --trace trace.jsonl
  seoro accept trace.jsonl maze.osc
  seoro accept --json trace.jsonl maze.osc

exit status: 0 accepted, 1 not accepted, 2 the command line, the trace or the scenario is invalid"""

_CODE = "E0530"
_MAX_SHOWN = 50  # violations, and things not checked, on the terminal


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("trace", metavar="TRACE", help="the trace, as `seoro exec --trace` writes it; - for stdin")
    parser.add_argument("file", metavar="SCENARIO", help="the scenario file (.osc) that was run")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object on stdout")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    records = _read(options.trace)
    acceptance = accept(load(options.file), records)
    if options.json:
        print(json.dumps(acceptance.plain(), ensure_ascii=False, indent=1))
    else:
        _show(acceptance, records)
    return Exit.PASSED if acceptance.accepted else Exit.FAILED


def _read(name: str) -> list[Record]:
    """The records of a trace."""
    problems: list[Unreadable] = []
    try:
        with open_bytes(name) as file:
            records = list(only_records(read_trace(file), problems))
    except OSError as error:
        raise InvalidUse(f"cannot read the trace {name}: {error.strerror}") from error
    if problems:
        raise InvalidUse(f"cannot read the trace {name}: {problems[0]}")
    if not records:
        raise InvalidUse(f"the trace {name} is empty", help="`seoro exec --trace FILE` writes one")
    return records


def _show(acceptance: Acceptance, records: list[Record]) -> None:
    """Print what was found: violations on stderr, the rest on stdout."""
    colour = use_colour(sys.stderr)
    for violation in acceptance.violations[:_MAX_SHOWN]:
        print(_violation(violation, records, colour=colour) + "\n", file=sys.stderr)
    hidden = len(acceptance.violations) - _MAX_SHOWN
    if hidden > 0:
        print(f"and {count(hidden, 'more violation')}: `--json` has all of them", file=sys.stderr)
    for unchecked in acceptance.unchecked[:_MAX_SHOWN]:
        print(_unchecked(unchecked))
    hidden = len(acceptance.unchecked) - _MAX_SHOWN
    if hidden > 0:
        print(f"and {hidden} more that were not checked: `--json` has all of them")
    what = count(acceptance.records, "record")
    if acceptance.accepted:
        print(f"accepted: {what}" + (", as far as it was checked" if acceptance.unchecked else ""))
    else:
        print(f"not accepted: {what}, {count(len(acceptance.violations), 'violation')}", file=sys.stderr)


def _violation(violation: Violation, records: list[Record], *, colour: bool) -> str:
    """A violation with the text of the scenario, and the records that show it."""
    message = f"{violation.message} ({_title(violation.rule.title, violation.rule.section)})"
    shown = ", ".join(_record(record) for record in records if record.get("seq") in violation.records)
    if violation.span is None:
        return f"error[{_CODE}]: {message}" + (f"\n  = help: see {shown}" if shown else "")
    hint = f"see {shown}" if shown else ""
    found = Diagnostic(Severity.ERROR, _CODE, message, Label(violation.span, ""), help=hint)
    return render_text(found, colour=colour)


def _record(record: Record) -> str:
    """A record in few words."""
    return f"record {record.get('seq')} ({record.get('kind')} at {record.get('t')} s)"


def _unchecked(unchecked: Unchecked) -> str:
    where = f"{unchecked.span}: " if unchecked.span is not None else ""
    times = f" ({unchecked.count} times)" if unchecked.count > 1 else ""
    return (
        f"not checked: {where}{unchecked.reason}{times} ({_title(unchecked.rule.title, unchecked.rule.section)})"
    )


def _title(title: str, section: str) -> str:
    return f"{title}, {section}"
