"""The built pages belong to the source in `ui/`."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path

import pytest

from tests.node_js import copy_source, needs_node, npm

ROOT = Path(__file__).parents[2]
UI = ROOT / "ui"
PAGES = ("report", "ui")
NAMES = ("{0}.js", "{0}.css", "LICENSES.txt", "source.txt")
FILES = ["report/static/world3d.js", *(f"{page}/static/{name.format(page)}" for page in PAGES for name in NAMES)]


@pytest.mark.parametrize("page", PAGES)
def test_built_pages_match_their_source(page: str) -> None:
    """`make ui` builds them; the hash is that of `ui/build.mjs`."""
    paths = sorted(
        path.relative_to(UI).as_posix()
        for path in UI.rglob("*")
        if path.is_file() and "node_modules" not in path.relative_to(UI).parts
    )
    digest = hashlib.sha256()
    for path in paths:
        digest.update(f"{path}\0".encode() + (UI / path).read_bytes() + b"\0")
    source = ROOT / "seoro" / page / "static/source.txt"
    assert source.read_text().strip() == digest.hexdigest(), "run `make ui`"


@needs_node
@pytest.mark.more
def test_building_again_gives_the_same_files(tmp_path: Path) -> None:
    copy = copy_source(UI, tmp_path / "ui")
    npm(copy, "ci")
    npm(copy, "run", "check")
    subprocess.run(["node", copy / "build.mjs", tmp_path / "built"], check=True)
    for name in FILES:
        built = ROOT / "seoro" / name
        assert (tmp_path / "built" / name).read_bytes() == built.read_bytes(), f"run `make ui`: {name} differs"


def test_built_pages_name_no_host_and_close_no_script() -> None:
    for page in PAGES:
        for script in (ROOT / f"seoro/{page}/static").glob("*.js"):
            assert "</script" not in script.read_text().lower()
        assert "</style" not in (ROOT / f"seoro/{page}/static/{page}.css").read_text().lower()
    assert "resolved" not in (UI / "package-lock.json").read_text()
