"""Campaigns: many runs of one scenario, planned, resumable, and evaluated with statistics.

    async with seoro.campaign.start("maze.osc", strategy=Uniform(), runs=2000, folder="out") as campaign:
        async for row in campaign.runs():
            ...
    print(campaign.rate())

The names below are its public interface. They are loaded when they are first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.lazy_names import lazy_names

if TYPE_CHECKING:
    from seoro.campaign.after.findings import Shrunk
    from seoro.campaign.after.shrink import shrink
    from seoro.campaign.comparison.comparing import Comparison, Outcome, compare
    from seoro.campaign.results.results import Results, read
    from seoro.campaign.runs import End, Row
    from seoro.campaign.session import Campaign
    from seoro.campaign.starting import resume, run, start
    from seoro.campaign.stopping.rate import Rate, Validity
    from seoro.campaign.strategies.boundary import Boundary
    from seoro.campaign.strategies.grid import Grid
    from seoro.campaign.strategies.latin import Latin
    from seoro.campaign.strategies.map_elites import MapElites
    from seoro.campaign.strategies.optimizers import CmaEs, Tpe
    from seoro.campaign.strategies.pairwise import Pairwise
    from seoro.campaign.strategies.random import Uniform
    from seoro.campaign.strategies.search import Search
    from seoro.campaign.strategies.sobol import Sobol

__all__ = [
    "Boundary",
    "Campaign",
    "CmaEs",
    "Comparison",
    "End",
    "Grid",
    "Latin",
    "MapElites",
    "Outcome",
    "Pairwise",
    "Rate",
    "Results",
    "Row",
    "Search",
    "Shrunk",
    "Sobol",
    "Tpe",
    "Uniform",
    "Validity",
    "compare",
    "read",
    "resume",
    "run",
    "shrink",
    "start",
]

_MODULES = {
    "seoro.campaign.after.findings": ("Shrunk",),
    "seoro.campaign.after.shrink": ("shrink",),
    "seoro.campaign.comparison.comparing": ("Comparison", "Outcome", "compare"),
    "seoro.campaign.results.results": ("Results", "read"),
    "seoro.campaign.runs": ("End", "Row"),
    "seoro.campaign.session": ("Campaign",),
    "seoro.campaign.starting": ("resume", "run", "start"),
    "seoro.campaign.stopping.rate": ("Rate", "Validity"),
    "seoro.campaign.strategies.boundary": ("Boundary",),
    "seoro.campaign.strategies.grid": ("Grid",),
    "seoro.campaign.strategies.latin": ("Latin",),
    "seoro.campaign.strategies.map_elites": ("MapElites",),
    "seoro.campaign.strategies.optimizers": ("CmaEs", "Tpe"),
    "seoro.campaign.strategies.pairwise": ("Pairwise",),
    "seoro.campaign.strategies.random": ("Uniform",),
    "seoro.campaign.strategies.search": ("Search",),
    "seoro.campaign.strategies.sobol": ("Sobol",),
}


def __dir__() -> list[str]:
    return __all__


if not TYPE_CHECKING:  # type checkers report unknown names
    __getattr__ = lazy_names(__name__, _MODULES)
