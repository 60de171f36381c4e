"""The result of runs as JUnit XML, as CI servers read it.

A run that failed is a failure, one without a verdict an error, one that was cancelled is skipped. The seed and the
chosen parameters are properties of the test case.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree as Xml

from seoro.runtime.verdict import RunStatus, Verdict

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(results: Sequence[tuple[Verdict, Mapping[str, object]]]) -> str:
    """An XML document with a test case for each result: its verdict, and its parameters by name."""
    counts = {status: sum(verdict.status is status for verdict, _ in results) for status in RunStatus}
    suite = Xml.Element(
        "testsuite",
        name="seoro",
        tests=str(len(results)),
        failures=str(counts[RunStatus.FAILED]),
        errors=str(counts[RunStatus.ERROR]),
        skipped=str(counts[RunStatus.CANCELLED]),
        time=f"{sum(verdict.wall_duration for verdict, _ in results):.3f}",
    )
    for verdict, parameters in results:
        suite.append(_case(verdict, parameters))
    suites = Xml.Element("testsuites")
    suites.append(suite)
    Xml.indent(suites)
    return Xml.tostring(suites, encoding="unicode", xml_declaration=True) + "\n"


def _case(verdict: Verdict, parameters: Mapping[str, object]) -> Xml.Element:
    case = Xml.Element(
        "testcase",
        name=_clean(verdict.scenario),
        classname=_clean(verdict.file),
        time=f"{verdict.wall_duration:.3f}",
    )
    properties = Xml.SubElement(case, "properties")
    facts = {
        "seed": verdict.seed,
        "duration": verdict.duration,
        **{f"parameter.{k}": v for k, v in parameters.items()},
    }
    for name, value in facts.items():
        Xml.SubElement(properties, "property", name=_clean(name), value=_clean(str(value)))
    kind = {RunStatus.FAILED: "failure", RunStatus.ERROR: "error", RunStatus.CANCELLED: "skipped"}.get(
        verdict.status
    )
    if kind is not None:
        place = f"{verdict.span}: " if verdict.span else ""
        found = Xml.SubElement(case, kind, message=_clean(verdict.reason))
        found.text = _clean(place + verdict.reason)
    return case


def _clean(text: str) -> str:
    """The text without characters that XML 1.0 cannot hold."""
    return _NOT_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text)
