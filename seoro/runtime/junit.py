"""The result of runs as JUnit XML, as CI servers read it.

A run that failed is a `failure`; one without a verdict, and a scenario that is invalid, an `error`; one that was
cancelled is `skipped`. Seed and chosen parameters are properties of the test case; its text says why, with the
lines of the scenario, and `system-out` has the last logs. Elements and attributes are those of the schemas of Ant
and of Maven Surefire; of properties of test cases, only newer ones know.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import field
from datetime import UTC, datetime
from xml.etree import ElementTree as Xml

from seoro.lang.frozen import Value
from seoro.runtime.verdict import RunStatus, Verdict

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Case(Value):
    """What became of one run.

    Args:
        name: Of the scenario, or of the file if no scenario of it could be run.
        file: The file, as the user named it.
        tag: `failure`, `error` or `skipped`; none for a run that passed.
        kind: A word for what happened, such as the status of the run.
        message: Why, in one line.
        text: Why, in full.
        duration: On the machine's clock [s].
        properties: Facts about it, by name.
        logs: The last logs.
    """

    name: str
    file: str
    tag: str | None = None
    kind: str = ""
    message: str = ""
    text: str = ""
    duration: float = 0.0
    properties: Mapping[str, object] = field(default_factory=dict)
    logs: Sequence[str] = ()


TAGS = {RunStatus.FAILED: "failure", RunStatus.ERROR: "error", RunStatus.CANCELLED: "skipped"}


def case_of(verdict: Verdict, parameters: Mapping[str, object], text: str = "") -> Case:
    """A run that has a verdict.

    Args:
        verdict: The verdict.
        parameters: The chosen parameters, by name.
        text: Why, as people read it; the reason with its place if there is none.
    """
    place = f"{verdict.span}: " if verdict.span else ""
    return Case(
        name=verdict.scenario,
        file=verdict.file,
        tag=TAGS.get(verdict.status),
        kind=verdict.status.value,
        message=verdict.reason,
        text=text or place + verdict.reason,
        duration=verdict.wall_duration,
        properties={
            "seed": verdict.seed,
            "duration": verdict.duration,
            **{f"parameter.{name}": value for name, value in parameters.items()},
        },
        logs=verdict.logs,
    )


def unrun_case(file: str, kind: str, message: str, text: str) -> Case:
    """A file that could not be run: its text is invalid, or how it was asked for, or there is no simulator."""
    return Case(name=file, file=file, tag="error", kind=kind, message=message, text=text)


def junit(cases: Sequence[Case]) -> str:
    """An XML document with a test case for each run, in UTF-8."""
    counts = {tag: str(sum(case.tag == tag for case in cases)) for tag in ("failure", "error", "skipped")}
    numbers = {
        "tests": str(len(cases)),
        "failures": counts["failure"],
        "errors": counts["error"],
        "time": f"{sum(case.duration for case in cases):.3f}",
    }
    suites = Xml.Element("testsuites", {"name": "seoro", **numbers})
    suite = Xml.SubElement(
        suites,
        "testsuite",
        {
            "name": "seoro",
            **numbers,
            "skipped": counts["skipped"],
            "timestamp": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S"),
            "hostname": _clean(platform.node()) or "localhost",
        },
    )
    for case in cases:
        _add(case, suite)
    Xml.indent(suites)
    return Xml.tostring(suites, encoding="unicode", xml_declaration=False).join((_HEADER, "\n"))


_HEADER = "<?xml version='1.0' encoding='UTF-8'?>\n"


def _add(case: Case, suite: Xml.Element) -> None:
    attributes = {"name": _clean(case.name), "classname": _clean(case.file), "time": f"{case.duration:.3f}"}
    element = Xml.SubElement(suite, "testcase", attributes)
    if case.properties:
        properties = Xml.SubElement(element, "properties")
        for name, value in case.properties.items():
            Xml.SubElement(properties, "property", name=_clean(name), value=_clean(str(value)))
    if case.tag is not None:
        found = Xml.SubElement(element, case.tag, message=_clean(case.message), type=case.kind)
        found.text = _clean(case.text)
    if case.logs:
        Xml.SubElement(element, "system-out").text = _clean("\n".join(case.logs) + "\n")


def _clean(text: str) -> str:
    """The text without characters that XML 1.0 cannot hold."""
    return _NOT_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text)
