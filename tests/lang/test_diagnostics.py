"""Golden messages: each `tests/data/diagnostics/*.osc` gives exactly the text of the `.err` beside it.

`SEORO_UPDATE_GOLDENS=1 pytest tests/lang/test_diagnostics.py` rewrites them; the diff is for review.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from seoro.lang import frontend
from seoro.lang.render import render_text

FOLDER = Path(__file__).parents[1] / "data" / "diagnostics"
CASES = sorted(FOLDER.glob("*.osc"))


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_the_messages_equal_the_golden_file(path: Path) -> None:
    checked = frontend.check(frontend.load(path, path.name))
    text = "\n\n".join(render_text(found) for found in checked.diagnostics) + "\n"
    golden = path.with_suffix(".err")
    if os.environ.get("SEORO_UPDATE_GOLDENS"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


def test_every_error_file_has_messages() -> None:
    assert len(CASES) > 30
    assert all(path.with_suffix(".err").read_text(encoding="utf-8").strip() for path in CASES)
