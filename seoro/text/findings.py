"""Findings in source files in the formats of CI services: errors of checks, and tests that did not pass."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import PurePath
from typing import Any, Final, NamedTuple
from urllib.parse import quote

SARIF: Final = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
_LEVELS: Final = {"error": "error", "warning": "warning"}  # of GitHub and SARIF; all others are notes


class Finding(NamedTuple):
    """A finding; lines and columns count from 1.

    Attributes:
        file: Path of the file.
        severity: `error`, `warning` or another word.
        code: Identifier of its kind, such as `E0312`.
        help: Advice; may be empty.
    """

    file: str
    line: int
    column: int
    end_line: int
    end_column: int
    severity: str
    code: str
    message: str
    help: str = ""


def as_json(findings: Sequence[Finding], titles: Mapping[str, str]) -> str:
    """Return a JSON list with an object for each finding."""
    return json.dumps([finding._asdict() for finding in findings], indent=1)


def as_github(findings: Sequence[Finding], titles: Mapping[str, str]) -> str:
    """Return workflow commands of GitHub Actions, which become annotations of the lines."""
    return "\n".join(map(_command, findings))


def _command(finding: Finding) -> str:
    places = {
        "file": finding.file,
        "line": finding.line,
        "endLine": finding.end_line,
        "col": finding.column,
        "endColumn": finding.end_column,
        "title": finding.code,
    }
    # Columns are for findings in one line only.
    kept = {name: value for name, value in places.items() if "ol" not in name or finding.line == finding.end_line}
    properties = ",".join(f"{name}={_escaped(str(value), ':,')}" for name, value in kept.items())
    text = f"{finding.message}\n{finding.help}" if finding.help else finding.message
    return f"::{_LEVELS.get(finding.severity, 'notice')} {properties}::{_escaped(text)}"


def _escaped(text: str, also: str = "") -> str:
    for character in ("%", "\r", "\n", *also):
        text = text.replace(character, f"%{ord(character):02X}")
    return text


def as_sarif(findings: Sequence[Finding], titles: Mapping[str, str]) -> str:
    """Return a SARIF 2.1.0 log, for services that show results of static analysis."""
    from seoro import __version__  # noqa: PLC0415 - for this format only

    codes = sorted({finding.code for finding in findings})
    rules = [{"id": code, "shortDescription": {"text": titles.get(code, code)}} for code in codes]
    driver = {"name": "seoro", "version": __version__, "rules": rules}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(finding, codes.index(finding.code)) for finding in findings],
    }
    return json.dumps({"$schema": SARIF, "version": "2.1.0", "runs": [run]}, indent=1)


def _result(finding: Finding, rule: int) -> dict[str, Any]:
    region = {
        "startLine": finding.line,
        "startColumn": finding.column,
        "endLine": finding.end_line,
        "endColumn": finding.end_column,
    }
    path = PurePath(finding.file)
    uri = path.as_uri() if path.is_absolute() else quote(path.as_posix())
    text = f"{finding.message}\n{finding.help}" if finding.help else finding.message
    return {
        "ruleId": finding.code,
        "ruleIndex": rule,
        "level": _LEVELS.get(finding.severity, "note"),
        "message": {"text": text},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}],
    }


FORMATS: Final[Mapping[str, Callable[[Sequence[Finding], Mapping[str, str]], str]]] = {
    "json": as_json,
    "github": as_github,
    "sarif": as_sarif,
}
"""Formats by name, besides text. The second argument has the titles of codes."""


def formatted(form: str, findings: Iterable[Finding], titles: Mapping[str, str]) -> str:
    """Return findings in a format of `FORMATS`."""
    return FORMATS[form](list(findings), titles)
