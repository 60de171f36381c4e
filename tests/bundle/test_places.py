"""Which paths may stand in a bundle."""

import pytest

from seoro.bundle.places import InvalidPlace, check_place


@pytest.mark.parametrize("path", ["a", "a/b.osc", "a b/ü.osc", ".hidden", "a..b"])
def test_plain_paths_may(path: str) -> None:
    assert str(check_place(path)) == path


@pytest.mark.parametrize(
    "path",
    [
        "",
        "/",
        "/etc/passwd",
        "..",
        "a/../../b",
        "./a",
        "a//b",
        "a/",
        "a\\b",
        "a\nb",
        "a\0b",
        "x" * 300,
        "a/" * 600,
    ],
)
def test_others_may_not(path: str) -> None:
    with pytest.raises(InvalidPlace):
        check_place(path)
