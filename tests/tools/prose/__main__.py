"""Check the prose of files and folders, or count its findings."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.tools.prose.exceptions import EXCEPTIONS
from tests.tools.prose.rules import RULES, Finding, check
from tests.tools.prose.texts import texts_in

CHECKED: tuple[str, ...] = (
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "README.md",
    "benchmarks",
    "docs",
    "editors",
    "examples",
    "scenarios",
    "seoro",
    "sim_nodes",
    "tests",
)  # files and folders of plain prose
SUFFIXES = (".py", ".md", ".osc")
SKIPPED = {
    *("test_prose.py", "exceptions.py", "CHANGELOG.md"),
    *("__pycache__", "node_modules", ".venv", "build", "dist"),
}


def files_in(paths: Sequence[Path]) -> Iterator[Path]:
    """Yield the files below some paths that contain prose."""
    for path in paths:
        if path.is_dir():
            yield from files_in(sorted(each for each in path.iterdir() if each.name not in SKIPPED))
        elif path.suffix in SUFFIXES:
            yield path


def findings_in(paths: Sequence[Path]) -> list[Finding]:
    """Return what breaks a rule in the files below some paths."""
    return [
        finding
        for file in files_in(paths)
        for text in texts_in(file)
        for finding in check(text)
        if (str(file), finding.found) not in EXCEPTIONS
    ]


def main(arguments: Sequence[str]) -> int:
    """Run the command, and return its exit status: 1 if a rule is broken."""
    parser = argparse.ArgumentParser(prog="python -m tests.tools.prose", description=__doc__)
    parser.add_argument("paths", metavar="PATH", nargs="*", type=Path, help="file or folder (default: CHECKED)")
    parser.add_argument("--count", action="store_true", help="print the number of findings of each kind only")
    options = parser.parse_args(arguments)
    findings = findings_in(options.paths or [Path(each) for each in CHECKED])
    if options.count:
        counts = Counter((finding.rule, finding.text.kind.value) for finding in findings)
        for rule in RULES:
            kinds = {kind: number for (name, kind), number in counts.items() if name == rule}
            shown = ", ".join(f"{number} in a {kind}" for kind, number in sorted(kinds.items()))
            print(f"{rule:9} {sum(kinds.values()):5}  {shown}")
        return 0
    for finding in findings:
        print(f"{finding.text.file}:{finding.text.line}: {finding.rule}: {finding.found}")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
