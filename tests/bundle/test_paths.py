"""Valid paths in bundles."""

from pathlib import Path

import pytest

from seoro.bundle.paths import InvalidPath, check_path, make_locator


@pytest.mark.parametrize("path", ["a", "a/b.osc", "a b/ü.osc", ".hidden", "a..b"])
def test_plain_paths_are_accepted(path: str) -> None:
    assert str(check_path(path)) == path


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
def test_unsafe_paths_are_refused(path: str) -> None:
    with pytest.raises(InvalidPath):
        check_path(path)


def test_unpacked_files_are_found_by_their_original_paths(tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "common/robots.osc").touch()
    locate = make_locator("/home/somebody", tmp_path)
    assert locate(Path("/home/somebody/common/robots.osc")) == tmp_path / "common/robots.osc"
    assert locate(Path("/home/somebody/tests/../common/robots.osc")) == tmp_path / "common/robots.osc"
    assert make_locator("/", tmp_path)(Path("/common")) == tmp_path / "common"


@pytest.mark.parametrize(
    "path",
    ["/home/somebody/other.osc", "/home/somebody/../x.osc", "/home/somebody", "/etc/passwd", "common/a.osc"],
)
def test_files_outside_of_a_bundle_keep_their_path(tmp_path: Path, path: str) -> None:
    (tmp_path.parent / "x.osc").touch()
    assert make_locator("/home/somebody", tmp_path)(Path(path)) == Path(path)
    assert make_locator(None, tmp_path)(Path(path)) == Path(path)
