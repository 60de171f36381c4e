"""Comparison of two campaigns as JSON data."""

from __future__ import annotations

from typing import Any

from seoro.campaign.comparison.comparing import Comparison
from seoro.campaign.comparison.pairs import Pair


def comparison_data(found: Comparison) -> dict[str, Any]:
    """Return the JSON data of a comparison."""
    return {
        "outcome": found.outcome.value,
        "reason": found.reason,
        "margin": found.margin,
        "is_paired": found.is_paired,
        "before": {"folder": str(found.before), "passed": found.counts[0][0], "runs": found.counts[0][1]},
        "after": {"folder": str(found.after), "passed": found.counts[1][0], "runs": found.counts[1][1]},
        "p": found.p,
        "drop_bound": found.drop_bound,
        "is_fixed": found.is_fixed,
        "pairs": len(found.joined.pairs),
        "equal": found.equal,
        "newly_failing": [_pair_data(found, pair) for pair in found.failing],
        "newly_passing": [_pair_data(found, pair) for pair in found.passing],
        "lost": [_pair_data(found, pair) for pair in found.lost],
        "measurements": [
            {
                "name": each.name,
                "variants": each.variants,
                "before": each.before,
                "after": each.after,
                "change": each.change,
                "low": each.bounds.low,
                "high": each.bounds.high,
                "p": each.p,
            }
            for each in found.measurements
        ],
        "differences": [
            {"name": each.name, "before": each.before, "after": each.after} for each in found.differences
        ],
    }


def _pair_data(found: Comparison, pair: Pair) -> dict[str, Any]:
    return {
        "values": pair.values,
        "seed": pair.seed,
        "before": pair.before.run,
        "after": pair.after.run,
        "reason": pair.reason,
        "command": found.command(pair),
    }
