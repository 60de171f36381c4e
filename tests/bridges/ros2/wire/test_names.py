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
def test_names_are_resolved_in_their_node(name: str, full: str) -> None:
    assert resolve(name, "/bot1", "driver") == full


def test_names_in_the_root_have_one_slash() -> None:
    assert resolve("scan", "/", "driver") == "/scan"
    assert resolve("~/state", "/", "driver") == "/driver/state"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "not empty"),
        ("/", "nothing between or after"),
        ("/scan/", "nothing between or after"),
        ("/a//b", "nothing between or after"),
        ("/2nd", "'2nd' has to be"),
        ("scan front", "'scan front' has to be"),
        ("/scan-front", "'scan-front' has to be"),
        ("~state", "begins with '~/'"),
        ("~", "begins with '~/'"),
        ("/a/~/b", "'~' has to be"),
        ("{ns}/scan", "substitutions"),
        ("/a" * 200, "has 400 characters"),
        ("/sc\u00e4n", "has to be"),
        ("/scan\n", "has to be"),
        ("/**", "has to be"),
    ],
)
def test_what_is_no_name_is_refused_with_its_reason(name: str, problem: str) -> None:
    with pytest.raises(InvalidName, match=problem.replace("*", r"\*")):
        resolve(name, "/bot1", "driver")


@pytest.mark.parametrize(("given", "full"), [("", "/"), ("/", "/"), ("bot1", "/bot1"), ("/a/b/", "/a/b")])
def test_namespaces_are_made_absolute(given: str, full: str) -> None:
    assert resolve_namespace(given) == full


@pytest.mark.parametrize("namespace", ["/1", "a b", "/a//b"])
def test_what_is_no_namespace_is_refused(namespace: str) -> None:
    with pytest.raises(InvalidName):
        resolve_namespace(namespace)


@pytest.mark.parametrize("name", ["", "a/b", "1a", "a-b", "a" * 256])
def test_what_is_no_name_of_a_node_is_refused(name: str) -> None:
    assert check_node_name("node_1") == "node_1"
    with pytest.raises(InvalidName):
        check_node_name(name)


def test_hidden_names_have_a_part_that_begins_with_an_underscore() -> None:
    assert is_hidden("/spin/_action/status")
    assert is_hidden("/_x")
    assert not is_hidden("/a_b/c_")
