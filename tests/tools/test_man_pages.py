"""Manual pages have all commands with their options."""

import shutil
import subprocess
from pathlib import Path

import pytest

from docs import man_pages
from seoro.cli.commands import COMMANDS


def test_pages_of_all_commands_are_written(tmp_path: Path) -> None:
    man_pages.main(tmp_path)
    names = {path.stem for path in tmp_path.iterdir()}
    assert names == {"seoro", *(f"seoro-{name}" for name in COMMANDS)}
    text = (tmp_path / "seoro-exec.1").read_text()
    assert text.startswith(".TH SEORO\\-EXEC")
    assert "\\fB\\-\\-seed\\fR" in text


@pytest.mark.skipif(shutil.which("man") is None, reason="man is not installed")
def test_a_page_is_shown_by_man(tmp_path: Path) -> None:
    page = tmp_path / "seoro-ros.1"
    page.write_text(man_pages.page_of("ros"))
    done = subprocess.run(["man", "-l", str(page)], capture_output=True, text=True, check=True, timeout=60)
    assert "seoro-ros topic echo" in done.stdout
