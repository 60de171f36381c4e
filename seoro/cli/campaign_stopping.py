"""Options of `seoro campaign run` that end a campaign; its pass rate and its exit status."""

from __future__ import annotations

import argparse

from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End
from seoro.campaign.state import State
from seoro.campaign.statistics.sequential_test import Decision
from seoro.campaign.stopping.watch import Watch
from seoro.cli.arguments import add_option, duration
from seoro.cli.exit_status import Exit


def add_stopping(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(
        parser,
        "--until RULE",
        "stop at: 'rate +- 2%%' (accuracy), 'rate >= 0.95' or 'rate >= 0.95 vs 0.90' (decision), 'first failure', "
        "'10 failures' or 'coverage 95%%'",
        repeatable=True,
    )
    add_option(parser, "--budget TIME", "begin no run after this wall time, such as 1h", type=duration)


def rate_text(state: State, *, is_complete: bool) -> str:
    """Return the pass rate with a comma in front, for a line of progress; empty if it estimates no probability.

    Args:
        state: State of the campaign.
        is_complete: Whether the campaign was carried out to its end.
    """
    rate = state.rate(is_complete=is_complete)
    return "" if rate.bounds is None or not rate.runs else f", {rate}"


def status_of_test(watch: Watch, tally: Tally) -> Exit | None:
    """Return the exit status of a campaign with a test of its rate; None without a test.

    Runs without a verdict are left out of the rate, so a campaign with such runs decides nothing.
    """
    if not watch.has_test:
        return None
    if not set(tally.ends) <= {End.PASSED, End.FAILED} or watch.stop is None:
        return Exit.ERROR
    return {Decision.GOOD: Exit.PASSED, Decision.BAD: Exit.FAILED}.get(watch.stop.decision, Exit.ERROR)
