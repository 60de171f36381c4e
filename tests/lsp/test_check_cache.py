"""Caches of checks do not change answers."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seoro.lang.check import body_cache
from seoro.lang.symbols import DoFound
from seoro.lsp.analysis import Analysis, CheckCache, analyse
from tests.lang.fuzzing import mutate_once, seeds
from tests.lsp.helpers import SCENARIO

SECOND = """
scenario other:
    robot: differential_drive_robot
    do serial:
        inner: serial:
            robot.init_nav2()
            wait elapsed(2s)
        wait @inner.end
"""
THIRD = """
scenario third:
    do serial:
        call_it: other()
        wait @call_it.inner.end
"""


def findings(analysis: Analysis) -> object:
    """Return the messages, and the meanings of all names by position."""
    names = [
        (use.span.start, use.span.end, type(use.meaning).__name__, analysis.index.target(use.meaning))
        for use in analysis.index.uses(analysis.path)
    ]
    return [repr(found) + str(found.position) for found in analysis.checked.diagnostics], names


def check_equal(path: Path, text: str, memory: CheckCache) -> None:
    """Compare an analysis with a cache with one without."""
    assert findings(analyse(path, {path: text}, memory=memory)) == findings(analyse(path, {path: text}))


@settings(max_examples=4, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**48))
def test_analyses_after_edits_equal_those_from_scratch(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    texts, path, memory = seeds(), tmp_path / "a.osc", CheckCache()
    text = chance.choice((SCENARIO + SECOND + THIRD, chance.choice(texts)))
    check_equal(path, text, memory)
    for _ in range(3):
        other = mutate_once(text, texts, chance)
        check_equal(path, other, memory)
        text = chance.choice((text, text, other))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("elapsed(2s)", "elapsed(2)"),  # an error in a body
        ("inner: serial", "within: serial"),  # a label that another body uses
        ("crate, height: 2m", "crate, height: 2s"),
        ("height: length = 1m", "height: time = 1s"),  # a declaration that bodies use
        ("import osc.helpers", "import osc.types"),
        ("# It is heavy.", "# It is light."),
        ("emit go(count: 3)", "emit go(count: 3"),  # a syntax error
        ("enum color", "enum colour"),
    ],
)
def test_edits_and_their_undoing_equal_checks_from_scratch(tmp_path: Path, old: str, new: str) -> None:
    path, memory = tmp_path / "a.osc", CheckCache()
    text = SCENARIO + SECOND + THIRD
    for state in (text, text.replace(old, new), text.replace(old, new) + SECOND, text):
        check_equal(path, state, memory)


def test_an_edit_of_one_body_checks_that_body_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, memory = tmp_path / "a.osc", CheckCache()
    text = SCENARIO + SECOND + THIRD
    analyse(path, {path: text}, memory=memory)
    checked: list[str] = []
    add = body_cache.ElaboratedBehaviors.add

    def noted(self: body_cache.ElaboratedBehaviors, found: DoFound) -> None:
        checked.append(found.owner.name)
        add(self, found)

    monkeypatch.setattr(body_cache.ElaboratedBehaviors, "add", noted)
    analysis = analyse(path, {path: text.replace("elapsed(2s)", "elapsed(3s)")}, memory=memory)
    assert checked == ["other"]
    assert analysis.index.uses(path)
    assert sorted(checked) == ["main", "other", "third"]
