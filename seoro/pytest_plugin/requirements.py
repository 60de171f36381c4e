"""Requirements that tests cover, with the outcomes of these (`--osc-requirements`).

A scenario names its requirements by `# seoro: requirement REQ-12`, a test in Python by the mark
`requirement("REQ-12")`. Earlier results come from the cache of pytest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import pytest

from seoro.cli.tables import table
from seoro.errors import UsageError
from seoro.files.inputs import Kind, read_input
from seoro.pytest_plugin import requirements_of

_CACHE: Final = "seoro/outcomes"
_TESTS: Final = "seoro_requirements"  # key of the data of xdist workers
_ORDER: Final = ("failed", "passed", "never run")  # the first that a test has is that of its requirement


class Requirements:
    """Plugin of pytest that prints a table of requirements.

    Args:
        config: Configuration of pytest.
        listed: File with the names of all requirements, a line each; None for those of tests alone.
    """

    def __init__(self, config: pytest.Config, listed: Path | None) -> None:
        self._config = config
        self._listed = [] if listed is None else _read(listed)
        self._tests: dict[str, list[str]] = {}  # names of tests by requirement
        self._outcomes: dict[str, str] = {}  # of this session, by the name of the test

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: Sequence[pytest.Item]) -> None:
        """Note the requirements of all tests, including deselected ones."""
        for item in items:
            for name in requirements_of(item):
                self._tests.setdefault(name, []).append(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note the outcome of a test; the last attempt counts."""
        if report.outcome == "failed":
            self._outcomes[report.nodeid] = "failed"
        elif report.when == "call" and report.outcome == "passed":
            self._outcomes[report.nodeid] = "passed"

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Pass the tests of a worker of pytest-xdist on."""
        output = getattr(session.config, "workeroutput", None)
        if output is not None:
            output[_TESTS] = self._tests

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take the tests of a worker of pytest-xdist over; all workers have the same."""
        self._tests = getattr(node, "workeroutput", {}).get(_TESTS, self._tests)

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Print the table, and keep the outcomes."""
        cache = getattr(self._config, "cache", None)
        before: dict[str, str] = {} if cache is None else cache.get(_CACHE, {})
        outcomes = {**before, **self._outcomes}
        if cache is not None:
            cache.set(_CACHE, outcomes)
        terminalreporter.section("requirements")
        rows = list(self._rows(outcomes))
        for line in table([("REQUIREMENT", "STATE", "TESTS"), *rows]).splitlines() if rows else ["none"]:
            terminalreporter.line(line)

    def _rows(self, outcomes: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
        for name in sorted({*self._tests, *self._listed}):
            tests = sorted(set(self._tests.get(name, ())))
            found = {outcomes.get(test, "never run") for test in tests}
            state = next((each for each in _ORDER if each in found), "not covered")
            is_earlier = state != "not covered" and not any(test in self._outcomes for test in tests)
            yield name, f"{state} (earlier)" if is_earlier and state != "never run" else state, ", ".join(tests)


def _read(file: Path) -> list[str]:
    """Read the names of all requirements.

    Raises:
        UsageError: The file cannot be read.
    """
    try:
        lines = read_input(file, Kind.SETTINGS).decode().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read the requirements in {file}: {error}") from None
    return [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]
