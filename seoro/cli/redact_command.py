"""`seoro redact`: remove names, hosts, paths and chosen fields from a trace, before it is shared."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from seoro.cli.arguments import add_option
from seoro.cli.files import STDIN, write_errors
from seoro.cli.trace_input import invalid_trace, open_trace
from seoro.errors import UsageError
from seoro.files.replacing import replacing
from seoro.traces.reader import InvalidRecord, read_trace, valid_records
from seoro.traces.redaction import Redactor, count_text

EXAMPLES = """examples:
  seoro redact out/trace.jsonl shared.jsonl
  seoro redact out/trace.jsonl shared.jsonl --name anna --name hall-3
  seoro redact out/trace.jsonl shared.jsonl --drop wall --drop scene:map --drop run.start:sources.text

Always replaced: folders of absolute paths, users of home folders, addresses such as anna@lab.org, hosts of
endpoints, and IP addresses. Equal texts get equal replacements. `seoro trace redact` is the same command.

exit status: 0; 2 if the trace or an option is invalid"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("trace", metavar="TRACE", help="trace (JSON Lines); - for stdin")
    parser.add_argument("output", metavar="OUTPUT", type=Path, help="file for the redacted trace")
    add_option(parser, "--name WORD", "replace this word, such as the name of a robot", repeatable=True)
    add_option(
        parser,
        "--drop FIELD",
        "remove a field of all records, or KIND:FIELD of one kind, also of nested objects (KIND:FIELD.FIELD)",
        repeatable=True,
    )


def run(options: argparse.Namespace) -> None:
    """Run the command."""
    source, target = options.trace, options.output
    if source != STDIN and target.exists() and Path(source).exists() and target.samefile(source):
        raise UsageError(f"the output would overwrite the trace {source}", help="choose another output")
    try:
        redactor = Redactor(options.name, options.drop)
    except ValueError as error:
        raise UsageError(str(error), help="for example `--drop scene:map`") from error
    problems: list[InvalidRecord] = []
    number = 0
    with open_trace(source) as file, write_errors(target), replacing(target) as partial:
        with partial.open("w", encoding="utf-8") as out:
            for record in valid_records(read_trace(file), problems):
                out.write(json.dumps(redactor.redact(record), ensure_ascii=False) + "\n")
                number += 1
        if problems or not number:
            raise invalid_trace(source, problems)
    print(f"{target}: {number} records, replaced {count_text(redactor.counts)}")
