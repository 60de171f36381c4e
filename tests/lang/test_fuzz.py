"""Fuzzing of the front end: any text quickly gives messages or a plan, without other exceptions."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from seoro.errors import InvalidScenario
from seoro.lang import frontend
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.render import render_text, to_json
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import EvaluationError
from tests.lang import fuzzing
from tests.lang.programs import PROGRAMS

# Limit of the time for a text relative to `_unit`; both slow down alike on a busy machine.
MAX_WORK = 60.0
SOON = 0.5  # [s] of a processor; shorter times are not compared
MAX_MEMORY = 300 * 2**10  # [KiB] growth of the process
QUICK = settings(max_examples=25, deadline=None, derandomize=True, database=None, phases=[Phase.generate])
LONG = settings(
    QUICK,
    derandomize=False,
    max_examples=int(os.environ.get("SEORO_FUZZ_EXAMPLES", "25000")),
    suppress_health_check=list(HealthCheck),
)
KINDS = {
    "soup": fuzzing.soup,
    "statements": fuzzing.statements,
    "mutated": fuzzing.mutated,
    "chosen": fuzzing.chosen,
}


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "test.osc"


def survives(path: Path, text: str) -> None:
    """Check that the front end reads any text within its limits."""
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    start, memory = time.thread_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    checked = frontend.check(frontend.load(path, "test.osc"))
    found = list(checked.diagnostics)
    if not checked.errors:
        try:
            plan = frontend.lower(checked, _entry(checked))
        except InvalidScenario as refused:
            found += refused.diagnostics
        else:
            with suppress(EvaluationError):
                entry_parameters(plan, seed=0)
    for diagnostic in found:
        is_well_formed(diagnostic)
    took = time.thread_time() - start
    assert took < SOON or took < MAX_WORK * _unit()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < MAX_MEMORY


def _unit() -> float:
    """Return the time of a fixed computation [s]; about 0.05 s on an idle machine."""
    start = time.thread_time()
    sum(number * number for number in range(1_000_000))
    return time.thread_time() - start


def _entry(checked: frontend.Checked) -> str | None:
    """Return the scenario to run of a file."""
    return "main" if "main" in checked.scenarios else next(iter(checked.scenarios), None)


def is_well_formed(diagnostic: Diagnostic) -> None:
    """Assert that a message can be shown, and points into its file."""
    assert diagnostic.message
    assert render_text(diagnostic)
    assert to_json(diagnostic)
    for label in (diagnostic.primary, *diagnostic.secondary):
        assert 0 <= label.span.start <= label.span.end <= len(label.span.file.text)


def survives_as_override(path: Path, text: str) -> None:
    """Check that the front end reads any override within its limits."""
    path.write_text(PROGRAMS[1], encoding="utf-8")
    checked = frontend.check(frontend.load(path, "test.osc"))
    try:
        assert frontend.lower(checked, "main", {"n": text}).entry == "main"
    except InvalidScenario as refused:
        for diagnostic in refused.diagnostics:
            is_well_formed(diagnostic)


@pytest.mark.parametrize("kind", KINDS)
def test_no_text_breaks_the_front_end(kind: str, path: Path) -> None:
    run(QUICK, KINDS[kind](), lambda text: survives(path, text))


def test_no_override_breaks_the_front_end(path: Path) -> None:
    run(QUICK, st.one_of(fuzzing.expressions(), fuzzing.soup()), lambda text: survives_as_override(path, text))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_no_text_of_a_long_fuzzing_breaks_the_front_end(kind: str, path: Path) -> None:
    run(LONG, KINDS[kind](), lambda text: survives(path, text))


@pytest.mark.slow
def test_no_override_of_a_long_fuzzing_breaks_the_front_end(path: Path) -> None:
    texts = st.one_of(fuzzing.expressions(), fuzzing.soup())
    run(LONG, texts, lambda text: survives_as_override(path, text))


def run(how: settings, texts: st.SearchStrategy[str], survive: Callable[[str], None]) -> None:
    """Run a check on generated texts."""

    @how
    @given(texts)
    def attempt(text: str) -> None:
        survive(text)

    attempt()
