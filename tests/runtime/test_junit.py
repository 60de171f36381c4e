"""Results as JUnit XML."""

from xml.etree import ElementTree as Xml

from seoro.runtime.junit import junit
from seoro.runtime.verdict import RunStatus, Verdict


def verdict(status: RunStatus, reason: str = "", file: str = "maze.osc") -> Verdict:
    return Verdict(status, reason, None, 2.0, 0.5, 7, "main", file)


def parse(text: str) -> Xml.Element:
    return Xml.fromstring(text.encode())


def test_statuses_are_told_apart() -> None:
    results: list[tuple[Verdict, dict[str, object]]] = [(verdict(status, "why"), {}) for status in RunStatus]
    suite = parse(junit(results))[0]
    assert suite.attrib | {"time": ""} == {
        "name": "seoro", "tests": "4", "failures": "1", "errors": "1", "skipped": "1", "time": ""
    }  # fmt: skip
    kinds = [[part.tag for part in case if part.tag != "properties"] for case in suite]
    assert kinds == [[], ["failure"], ["error"], ["skipped"]]


def test_a_failure_has_its_reason() -> None:
    failure = parse(junit([(verdict(RunStatus.FAILED, "too late"), {})])).find(".//failure")
    assert failure is not None
    assert failure.get("message") == "too late"


def test_seed_and_parameters_are_properties() -> None:
    case = parse(junit([(verdict(RunStatus.PASSED), {"speed": 1.5})]))[0][0]
    assert {p.get("name"): p.get("value") for p in case.iter("property")} == {
        "seed": "7", "duration": "2.0", "parameter.speed": "1.5"
    }  # fmt: skip


def test_any_name_and_reason_gives_valid_xml() -> None:
    text = junit([(verdict(RunStatus.FAILED, 'a & b < "c" \x00\x1b', file="a&b<'\">.osc"), {"p": "\ud800 \x07"})])
    case = parse(text)[0][0]
    assert case.get("classname") == "a&b<'\">.osc"
