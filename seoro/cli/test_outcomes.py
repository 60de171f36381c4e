"""Tests that did not pass, as findings for CI services."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import pytest

from seoro.cli.notifying import ended
from seoro.text.findings import Finding

TITLES: Final = {"failed": "Scenario failed", "error": "Scenario without a verdict"}
_STATUSES: Final[Mapping[int | None, str]] = {0: "passed", 1: "failed", 2: "cancelled"}  # of pytest
_MOST_NAMES: Final = 100  # of tests in a notification
_LONGEST: Final = 2000  # [characters] of the message of a finding


@dataclass(eq=False)  # pytest needs hashable plugins
class Outcomes:
    """Plugin of pytest that counts tests and collects failed ones.

    Attributes:
        findings: Tests that did not pass, in the order of their ends.
        passed: Number of tests that passed.
        skipped: Number of skipped tests.
        status: Exit status of pytest; None before its end.
    """

    findings: list[Finding] = field(default_factory=list)
    passed: int = 0
    skipped: int = 0
    status: int | None = None

    def content(self, error: BaseException | None) -> dict[str, Any]:
        """Return the result for notifications.

        Args:
            error: Exception that ended the command, if any.
        """
        names = [finding.message.partition(": ")[0] for finding in self.findings]
        return {
            **ended(_STATUSES.get(self.status, "error"), error),
            "passed": self.passed,
            "failed": sum(finding.code == "failed" for finding in self.findings),
            "errors": sum(finding.code == "error" for finding in self.findings),
            "skipped": self.skipped,
            "failures": names[:_MOST_NAMES],
        }

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note a test that did not pass."""
        self.passed += report.outcome == "passed" and report.when == "call"
        self.skipped += report.outcome == "skipped"
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
