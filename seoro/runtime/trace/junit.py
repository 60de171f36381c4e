"""Results of runs as JUnit XML, for CI servers.

A failed run is a `failure`; a run without a verdict and an invalid scenario are an `error`; a cancelled run is
`skipped`. Seed and chosen parameters are properties of the test case. Its text explains the result with lines of
the scenario, and `system-out` has the last logs. Elements and attributes follow the schemas of Ant and of Maven
Surefire; only newer ones allow properties of test cases.
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
    """Result of one run.

    Args:
        name: Name of the scenario, or of the file if no scenario could be run.
        file: The file, as given by the user.
        tag: `failure`, `error` or `skipped`; None for a passed run.
        kind: Type of the result, such as the status of the run.
        message: Reason in one line.
        text: Full explanation.
        duration: Duration on the machine's clock [s].
        properties: Further data by name.
        requirements: Names of requirements that the run covers, each a property `requirement`.
        logs: Last logs.
    """

    name: str
    file: str
    tag: str | None = None
    kind: str = ""
    message: str = ""
    text: str = ""
    duration: float = 0.0
    properties: Mapping[str, object] = field(default_factory=dict)
    requirements: Sequence[str] = ()
    logs: Sequence[str] = ()


TAGS = {RunStatus.FAILED: "failure", RunStatus.ERROR: "error", RunStatus.CANCELLED: "skipped"}


def case_of(verdict: Verdict, parameters: Mapping[str, object], text: str = "") -> Case:
    """Create the case of a run with a verdict.

    Args:
        verdict: The verdict.
        parameters: Chosen parameters by name.
        text: Explanation; by default, the reason with its place.
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
        requirements=verdict.requirements,
        logs=verdict.logs,
    )


def unrun_case(file: str, kind: str, message: str, text: str) -> Case:
    """Create the case of a file that could not be run, for example because it is invalid."""
    return Case(name=file, file=file, tag="error", kind=kind, message=message, text=text)


def junit(cases: Sequence[Case]) -> str:
    """Return an XML document with a test case per run."""
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
    named = [*case.properties.items(), *(("requirement", name) for name in case.requirements)]
    if named:
        properties = Xml.SubElement(element, "properties")
        for name, value in named:
            Xml.SubElement(properties, "property", name=_clean(name), value=_clean(str(value)))
    if case.tag is not None:
        found = Xml.SubElement(element, case.tag, message=_clean(case.message), type=case.kind)
        found.text = _clean(case.text)
    if case.logs:
        Xml.SubElement(element, "system-out").text = _clean("\n".join(case.logs) + "\n")


def _clean(text: str) -> str:
    """Replace characters that XML 1.0 does not allow."""
    return _NOT_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text)
