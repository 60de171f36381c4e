"""The built pages belong to the source in `ui/`."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
UI = ROOT / "ui"
PAGES = ("report", "ui")
NAMES = ("{0}.js", "{0}.css", "LICENSES.txt", "source.txt")
FILES = [f"{page}/static/{name.format(page)}" for page in PAGES for name in NAMES]


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


@pytest.mark.skipif(
    shutil.which("node") is None or not (UI / "node_modules/esbuild").is_dir(),
    reason="needs Node.js and `make ui`",
)
def test_building_again_gives_the_same_files(tmp_path: Path) -> None:
    subprocess.run(["node", UI / "build.mjs", tmp_path], check=True)
    for name in FILES:
        built = ROOT / "seoro" / name
        assert (tmp_path / name).read_bytes() == built.read_bytes(), f"run `make ui`: {name} differs"


def test_built_pages_name_no_host_and_close_no_script() -> None:
    for page in PAGES:
        script = (ROOT / f"seoro/{page}/static/{page}.js").read_text()
        assert "</script" not in script.lower()
        assert "</style" not in (ROOT / f"seoro/{page}/static/{page}.css").read_text().lower()
    assert "resolved" not in (UI / "package-lock.json").read_text()
