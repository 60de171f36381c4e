"""Statistics of campaigns: how often intervals exclude the true rate, and how many runs a test needs.

python -m benchmarks.campaigns intervals
"""

from __future__ import annotations

import argparse

from seoro.campaign.statistics.rates import fixed_bounds, live_bounds
from seoro.campaign.statistics.sequential_test import SequentialTest
from tests.campaign.statistics.exact import decisions, probability_of_exclusion

RATES = (0.5, 0.9, 0.97)
TEST = SequentialTest(good=0.97, bad=0.90)


def intervals(runs: int) -> None:
    """Print exact probabilities for campaigns whose runs pass independently with a rate.

    Args:
        runs: Number of runs, after each of which the interval is read.
    """
    print(f"95 % interval read after each of {runs:,} runs; it excludes the true rate at some time:")
    for rate in RATES:
        live, naive = (probability_of_exclusion(each, rate, runs) for each in (live_bounds, fixed_bounds))
        print(f"  rate {rate}: confidence sequence {live:.1%}, Clopper-Pearson {naive:.1%}", flush=True)
    print(f"test of {TEST.good} against {TEST.bad}, errors {TEST.errors}:")
    for rate in (0.8, TEST.bad, 0.93, 0.95, TEST.good, 0.99):
        accepted, mean = decisions(TEST, rate)
        print(f"  rate {rate}: decides for {TEST.good} in {accepted:.1%}, after {mean:.0f} runs on average")


def main() -> None:
    """Run a part."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=["intervals"])
    parser.add_argument("--runs", type=int, default=2000)
    intervals(parser.parse_args().runs)


if __name__ == "__main__":
    main()
