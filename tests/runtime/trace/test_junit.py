"""Results as JUnit XML."""

import re
from xml.etree import ElementTree as Xml

from seoro.runtime.trace.junit import Case, case_of, junit, unrun_case
from seoro.runtime.verdict import RunStatus, Verdict


def verdict(status: RunStatus, reason: str = "", file: str = "maze.osc", logs: tuple[str, ...] = ()) -> Verdict:
    return Verdict(status, reason, None, 2.0, 0.5, 7, "main", file, logs=logs)


def parse(*cases: Case) -> Xml.Element:
    return Xml.fromstring(junit(cases).encode())


def test_statuses_are_distinguished() -> None:
    suites = parse(*[case_of(verdict(status, "why"), {}) for status in RunStatus])
    suite = suites[0]
    assert suite.attrib | {"time": "", "timestamp": "", "hostname": ""} == {
        "name": "seoro", "tests": "4", "failures": "1", "errors": "1", "skipped": "1", "time": "", "timestamp": "",
        "hostname": "",
    }  # fmt: skip
    kinds = [[part.tag for part in case if part.tag != "properties"] for case in suite]
    assert kinds == [[], ["failure"], ["error"], ["skipped"]]


def test_a_failure_has_its_reason_and_the_whole_text() -> None:
    failure = parse(case_of(verdict(RunStatus.FAILED, "too late"), {}, "in full")).find(".//failure")
    assert failure is not None
    assert failure.attrib == {"message": "too late", "type": "failed"}
    assert failure.text == "in full"


def test_seed_and_parameters_are_properties() -> None:
    case = parse(case_of(verdict(RunStatus.PASSED), {"speed": 1.5}))[0][0]
    assert {p.get("name"): p.get("value") for p in case.iter("property")} == {
        "seed": "7", "duration": "2.0", "parameter.speed": "1.5"
    }  # fmt: skip


def test_the_last_logs_are_its_output() -> None:
    case = parse(case_of(verdict(RunStatus.FAILED, "why", logs=("one", "two")), {}))[0][0]
    assert case.findtext("system-out") == "one\ntwo\n"


def test_an_invalid_scenario_is_an_error() -> None:
    suites = parse(unrun_case("maze.osc", "invalid", "no `x`", "error: no `x`\n --> maze.osc:1:1"))
    error = suites.find(".//error")
    assert error is not None
    assert error.attrib == {"message": "no `x`", "type": "invalid"}
    assert suites[0].get("errors") == "1"


def test_any_name_and_reason_gives_valid_xml() -> None:
    strange = 'a & b < "c" ]]> \x00\x1b\ud800\uffff\r'
    case = Case(strange, strange, "failure", "failed", strange, strange, 1.0, {strange: strange}, (strange,))
    element = parse(case)[0][0]
    assert (element.get("name") or "").startswith('a & b < "c" ]]> \ufffd\ufffd\ufffd\ufffd')
    assert (element.find("failure") or element).attrib


# Rules of the schemas of Apache Ant and Maven Surefire: required and optional attributes, order of elements, and
# formats of numbers and times. In newer versions, test cases have properties.
REQUIRED = {
    "testsuites": set(),
    "testsuite": {"name", "tests", "failures", "errors", "skipped", "time", "timestamp", "hostname"},
    "testcase": {"name", "classname", "time"},
    "property": {"name", "value"},
    "failure": {"message", "type"},
    "error": {"message", "type"},
    "skipped": {"message", "type"},
}
OPTIONAL = {"testsuites": {"name", "tests", "failures", "errors", "time"}}
ORDER = {
    "testsuites": ["testsuite"],
    "testsuite": ["properties", "testcase", "system-out", "system-err"],
    "testcase": ["properties", "skipped", "error", "failure", "system-out", "system-err"],
    "properties": ["property"],
}
FORMS = {
    "time": r"\d+\.\d{3}",
    "timestamp": r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d",
    "tests": r"\d+",
    "failures": r"\d+",
    "errors": r"\d+",
    "skipped": r"\d+",
}


def check_schema(element: Xml.Element) -> None:
    tag, attributes = element.tag, set(element.attrib)
    assert REQUIRED.get(tag, set()) <= attributes <= REQUIRED.get(tag, set()) | OPTIONAL.get(tag, set()), tag
    for name, form in FORMS.items():
        assert name not in attributes or re.fullmatch(form, element.attrib[name]), (tag, name)
    places = [ORDER.get(tag, []).index(part.tag) for part in element]
    assert places == sorted(places), tag
    assert tag == "testsuite" or tag in {"testsuites", "properties"} or len(places) == len(set(places)), tag
    for part in element:
        check_schema(part)


def test_documents_follow_the_common_schema() -> None:
    cases = [case_of(verdict(status, "why", logs=("log",)), {"a": 1}) for status in RunStatus]
    suites = parse(*cases, unrun_case("maze.osc", "invalid", "message", "text"))
    check_schema(suites)
    suite = suites[0]
    assert int(suite.attrib["tests"]) == len(suite.findall("testcase"))
    for count, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        assert int(suite.attrib[count]) == len(suite.findall(f"testcase/{tag}"))
