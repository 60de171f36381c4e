"""Which paths may stand in a bundle."""

from pathlib import Path

import pytest

from seoro.bundle.places import InvalidPlace, check_place, locating


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


def test_files_are_found_by_the_paths_that_they_had(tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "common/robots.osc").touch()
    locate = locating("/home/somebody", tmp_path)
    assert locate(Path("/home/somebody/common/robots.osc")) == tmp_path / "common/robots.osc"
    assert locate(Path("/home/somebody/tests/../common/robots.osc")) == tmp_path / "common/robots.osc"
    assert locating("/", tmp_path)(Path("/common")) == tmp_path / "common"


@pytest.mark.parametrize(
    "path",
    ["/home/somebody/other.osc", "/home/somebody/../x.osc", "/home/somebody", "/etc/passwd", "common/a.osc"],
)
def test_what_is_not_in_a_bundle_keeps_its_path(tmp_path: Path, path: str) -> None:
    (tmp_path.parent / "x.osc").touch()
    assert locating("/home/somebody", tmp_path)(Path(path)) == Path(path)
    assert locating(None, tmp_path)(Path(path)) == Path(path)
