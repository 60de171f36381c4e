"""Campaigns as tests."""

from __future__ import annotations

import pytest

from tests.pytest_plugin.conftest import HEADER, Project

TEXT = """scenario main:
    load: float
    keep(load in [0.0..1.0])
    do serial:
        wait elapsed(2s)
        compare(load, "<", {limit})
"""
MARKED = "# pytest: seoro_campaign(rate={rate}, runs={runs}, jobs=1)\n"


def test_a_failure_shows_the_interval_the_reasons_and_the_report(project: Project) -> None:
    text = MARKED.format(rate=0.9, runs=200) + TEXT.format(limit=0.5)
    result = project(a=text).runpytest_inprocess(".", "--basetemp=kept", "--osc-seed=3")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "pass rate * % (* to * %, valid at any time); expected at least 90 % with 95 % confidence",
            "a.osc: * passed, * failed",
            "*`compare` failed: `# < #` is false at a.osc:*",
            "* seoro campaign replay */kept/main0/campaign *",
            "report: */kept/main0/campaign/report.html",
        ]
    )
    result.stdout.no_fnmatch_line("*.py*:*")


def test_functions_in_python_run_the_campaign_of_their_mark_first(project: Project) -> None:
    pytester = project()
    (pytester.path / "tests").mkdir()
    (pytester.path / "tests" / "gaps.osc").write_text(HEADER + TEXT.format(limit=0.9))
    (pytester.path / "tests" / "test_gaps.py").write_text("""import pytest
import seoro.campaign as sc


@pytest.mark.seoro_campaign("gaps.osc", rate=0.6, runs=100, vary=["load in [0.0..0.5]"], jobs=1)
def test_gaps(tmp_path):
    rows = sc.read(tmp_path / "campaign").rows()
    assert rows and all(row.values["load"] <= 0.5 for row in rows)


@pytest.mark.seoro_campaign("gaps.osc", rate=0.89, runs=2, jobs=1)
def test_few_runs():
    raise AssertionError("it runs after the campaign only")


@pytest.mark.seoro_campaign("gaps.osc")
def test_without_rate():
    pass


@pytest.mark.seoro_campaign(rate=0.5)
def test_without_file():
    pass


@pytest.mark.seoro_campaign("nothing.osc", rate=0.5)
def test_missing_file():
    pass


@pytest.mark.seoro_campaign("gaps.osc", rate=95)
def test_invalid_rate():
    pass
""")
    result = pytester.runpytest_inprocess("tests", "-k", "not osc")
    result.assert_outcomes(passed=1, failed=5)
    result.stdout.fnmatch_lines(
        [
            "2 runs do not decide this; expect a lower rate, or allow more `runs`",
            "*invalid mark `seoro_campaign`: missing a required argument: 'rate'",
            "*invalid mark `seoro_campaign`: expected a scenario file, found none",
            "*nothing.osc*",
            "*invalid stopping rule `rate >= 95`: expected a rate between 0 and 100 %, found 95",
        ]
    )
    result.stdout.no_fnmatch_line("*after the campaign only*")


@pytest.mark.parametrize(
    ("comments", "message"),
    [
        ('# pytest: seoro_campaign("a.osc", rate=0.9)\n', "expected no file, found 'a.osc'"),
        ("# seoro: expect failed\n# pytest: seoro_campaign(rate=0.9)\n", "contradicts the mark `seoro_campaign`"),
        ("# pytest: seoro_campaign(rates=0.9)\n", "invalid mark `seoro_campaign`"),
        ("# pytest: seoro_campaign(rate=0.9, runs=0)\n", "invalid `runs`: found 0, expected at least 1"),
    ],
)
def test_invalid_marks_fail_with_a_message(project: Project, comments: str, message: str) -> None:
    result = project(a=comments + TEXT.format(limit=0.5)).runpytest_inprocess(".")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"*{message}*"])
