"""Comparison of two campaigns as text."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.campaign.comparison.comparing import Comparison
from seoro.campaign.stopping.rules import percent


def verdict_lines(comparison: Comparison) -> Iterator[str]:
    """Yield the reason of the outcome, the numbers behind it, and what limits it."""
    yield f"{comparison.reason[0].upper()}{comparison.reason[1:]}."
    (passed, runs), (others, total) = comparison.counts
    if runs and total:
        rates = f"{percent(passed / runs)} of {runs:,} passed before, {percent(others / total)} of {total:,} after"
        test = "McNemar's exact test" if comparison.is_paired else "Fisher's exact test"
        yield f"{rates}; {p_text(comparison.p)} ({test})."
    if comparison.is_paired:
        lost = f", {len(comparison.lost):,} without a verdict now" if comparison.lost else ""
        same = f", {comparison.equal:,} equal to the bit" if comparison.equal else ""
        changes = f"{len(comparison.failing):,} newly failing, {len(comparison.passing):,} newly passing"
        yield f"{runs:,} pairs of runs: {changes}{lost}{same}."
    else:
        yield (
            f"{len(comparison.joined.pairs):,} runs have the same values, seed and repeat in both. "
            "So all runs were compared as independent ones, which needs many more."
        )
    if not comparison.is_fixed:
        yield "Rules or extensions determined the number of runs, so errors are more frequent than stated."


def p_text(p: float | None) -> str:
    """Return a p-value with two digits: `p = 0.031`."""
    if p is None:
        return "p unknown"
    return "p < 0.0001" if p < 0.0001 else f"p = {p:.2g}"


def number_text(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"
