"""The tools of a server."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, TypeVar

import anyio.to_thread

from seoro.mcp import reading, results, running
from seoro.mcp.reading import ScenarioReader
from seoro.mcp.results import ResultReader
from seoro.mcp.running import Runner
from seoro.mcp.tool import Tool

T = TypeVar("T")


def make_tools(scenarios: ScenarioReader, found: ResultReader, runner: Runner | None) -> Mapping[str, Tool]:
    """Return the tools by name.

    Args:
        scenarios: Reader of scenarios.
        found: Reader of results.
        runner: Runner of scenarios; None if agents may not run any.
    """
    tools = [
        Tool(
            "list_scenarios",
            "List the scenarios below the served folder.",
            reading.ListScenarios,
            reading.Scenarios,
            _in_thread(scenarios.list_scenarios),
        ),
        Tool(
            "describe_scenario",
            "Show the parameters of a scenario, and the simulators, robots and requirements that it names.",
            reading.DescribeScenario,
            reading.ScenarioDescription,
            _in_thread(scenarios.describe_scenario),
        ),
        Tool(
            "check_scenarios",
            "Check scenario files without running them, and without their Python. Errors come first.",
            reading.CheckScenarios,
            reading.Findings,
            _in_thread(scenarios.check_scenarios),
        ),
        Tool(
            "explain_code",
            "Explain the code of a finding, with a wrong and a right example.",
            reading.ExplainCode,
            reading.CodeExplanation,
            _in_thread(scenarios.explain_code),
        ),
        Tool(
            "list_runs",
            "List the runs whose output folders are below the served folder, the latest first.",
            results.ListRuns,
            results.Runs,
            _in_thread(found.list_runs),
        ),
        Tool(
            "explain_run",
            "Show the verdict of a run, why it was reached, failed behaviors, values, measurements and logs.",
            results.ExplainRun,
            results.RunResult,
            _in_thread(found.explain_run),
        ),
        Tool(
            "compare_runs",
            "Find where two runs first differ: settings, verdicts and records.",
            results.CompareRuns,
            results.RunComparison,
            _in_thread(found.compare_runs),
        ),
        Tool(
            "compare_campaigns",
            "Test whether the second of two campaigns is worse than the first.",
            results.CompareCampaigns,
            results.CampaignComparison,
            _in_thread(found.compare_campaigns),
        ),
    ]
    if runner is not None:
        tools.append(
            Tool(
                "run_scenario",
                "Run a scenario in a simulator, and return its verdict with reasons. Runs are sequential. Results "
                f"go to a new folder below `{running.FOLDER}`.",
                running.RunScenario,
                running.RunOutcome,
                runner.run_scenario,
                reads_only=False,
            )
        )
    return {tool.name: tool for tool in tools}


def _in_thread(function: Callable[[Any], T]) -> Callable[[Any], Awaitable[T]]:
    """Return a coroutine function that calls a function in a thread, which a cancelled request does not await."""

    async def call(given: Any) -> T:
        return await anyio.to_thread.run_sync(function, given, abandon_on_cancel=True)

    return call
