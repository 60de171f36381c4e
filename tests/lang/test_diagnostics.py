"""Golden messages: each `tests/data/diagnostics/*.osc` gives exactly the text of the `.err` beside it.

`SEORO_UPDATE_GOLDENS=1 pytest tests/lang/test_diagnostics.py` rewrites them; the diff is for review.
"""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

import pytest

from seoro.lang import diagnostics, frontend
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.render import render_text
from seoro.lang.source import SourceFile, Span

FOLDER = Path(__file__).parents[1] / "data" / "diagnostics"
CASES = sorted(FOLDER.glob("*.osc"))
PHASES = sorted(path.stem for path in Path(diagnostics.__file__).parent.glob("[a-z]*.py"))
SPAN = Span(SourceFile("maze.osc", "word"), 0, 4)
VALUES: dict[Any, tuple[Any, ...]] = {
    Span: (SPAN,),
    Span | None: (SPAN, None),
    str: ("word",),
    str | None: ("word", None),
    int: (3, 0),
    float: (1.0, 0.0),
    bool: (True, False),
    tuple[str, ...]: (("word", "words"), ()),
    tuple[str, str]: (("word", "words"),),
    tuple[int, ...]: ((0, 4), ()),
}


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


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("number", [0, -1])
def test_every_message_has_a_code_and_a_text(phase: str, number: int) -> None:
    module = import_module(f"seoro.lang.diagnostics.{phase}")
    own = [found for found in vars(module).values() if getattr(found, "__module__", "") == module.__name__]
    types = {found: get_type_hints(found) for found in own if not found.__name__.startswith("_")}
    messages = {found: hints for found, hints in types.items() if hints.pop("return") is Diagnostic}
    assert messages
    for message, hints in messages.items():
        made = message(**{name: VALUES[type_][number] for name, type_ in hints.items()})
        assert made.code.startswith("E")
        assert made.message
        assert made.primary.span is SPAN
