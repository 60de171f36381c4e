"""Names of ROS 2."""

import pytest

from seoro.bridges.ros2.wire import InvalidName, check_node_name, is_hidden, resolve, resolve_namespace


@pytest.mark.parametrize(
    ("name", "full"),
    [
        ("/scan", "/scan"),
        ("scan", "/bot1/scan"),
        ("camera/image_raw", "/bot1/camera/image_raw"),
        ("~/state", "/bot1/driver/state"),
        ("/_hidden/x2", "/_hidden/x2"),
    ],
)
def test_relative_names_are_resolved_in_their_node(name: str, full: str) -> None:
    assert resolve(name, "/bot1", "driver") == full


def test_names_in_the_root_have_one_slash() -> None:
    assert resolve("scan", "/", "driver") == "/scan"
    assert resolve("~/state", "/", "driver") == "/driver/state"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "empty name"),
        ("/", "empty part between or after"),
        ("/scan/", "empty part between or after"),
        ("/a//b", "empty part between or after"),
        ("/2nd", "invalid part '2nd'"),
        ("scan front", "invalid part 'scan front'"),
        ("/scan-front", "invalid part 'scan-front'"),
        ("~state", "begin with '~/'"),
        ("~", "begin with '~/'"),
        ("/a/~/b", "invalid part '~'"),
        ("{ns}/scan", "substitutions"),
        ("/a" * 200, "has 400 characters"),
        ("/sc\u00e4n", "invalid part"),
        ("/scan\n", "invalid part"),
        ("/**", "invalid part"),
    ],
)
def test_invalid_names_are_refused_with_the_reason(name: str, problem: str) -> None:
    with pytest.raises(InvalidName, match=problem.replace("*", r"\*")):
        resolve(name, "/bot1", "driver")


@pytest.mark.parametrize(("given", "full"), [("", "/"), ("/", "/"), ("bot1", "/bot1"), ("/a/b/", "/a/b")])
def test_namespaces_are_made_absolute(given: str, full: str) -> None:
    assert resolve_namespace(given) == full


@pytest.mark.parametrize("namespace", ["/1", "a b", "/a//b"])
def test_invalid_namespaces_are_refused(namespace: str) -> None:
    with pytest.raises(InvalidName):
        resolve_namespace(namespace)


@pytest.mark.parametrize("name", ["", "a/b", "1a", "a-b", "a" * 256])
def test_invalid_node_names_are_refused(name: str) -> None:
    assert check_node_name("node_1") == "node_1"
    with pytest.raises(InvalidName):
        check_node_name(name)


def test_names_with_a_part_that_starts_with_an_underscore_are_hidden() -> None:
    assert is_hidden("/spin/_action/status")
    assert is_hidden("/_x")
    assert not is_hidden("/a_b/c_")
