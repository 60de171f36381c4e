"""Tests that did not pass, as findings for CI services."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import pytest

from seoro.text.findings import Finding

TITLES: Final = {"failed": "Scenario failed", "error": "Scenario without a verdict"}
_LONGEST: Final = 2000  # [characters] of the message of a finding


@dataclass
class Outcomes:
    """Plugin of pytest that collects the tests that did not pass.

    Attributes:
        findings: Tests that did not pass, in the order of their ends.
    """

    findings: list[Finding] = field(default_factory=list)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a test that did not pass."""
        if report.outcome == "failed":
            path, line, name = report.location
            self._add(path, 1 if line is None else line + 1, name, report)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note a file that could not be read."""
        if report.outcome == "failed":
            self._add(report.nodeid, 1, report.nodeid, report)

    def _add(self, path: str, line: int, name: str, report: pytest.TestReport | pytest.CollectReport) -> None:
        is_run = isinstance(report, pytest.TestReport) and report.when == "call"
        text = report.longreprtext.strip()[:_LONGEST]
        code = "failed" if is_run else "error"
        self.findings.append(Finding(path, line, 1, line, 1, "error", code, f"{name}: {text}"))
