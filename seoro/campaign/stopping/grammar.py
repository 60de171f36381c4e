"""Grammar of stopping rules.

rule  = "rate" ("+-" | "±") share
      | "rate" ">=" share
      | "rate" ">=" share "vs" share ["errors" share]
      | "first failure"
      | count "failures"
      | "coverage" share
share = NUMBER | NUMBER "%"
"""

from __future__ import annotations

import re
from typing import Final

from seoro.campaign.statistics.sequential_test import ERRORS, SequentialTest
from seoro.campaign.stopping.rules import Accuracy, CoverageGoal, Failures, RateBound, RateTest, Rule
from seoro.errors import UsageError

_SHARE: Final = r"(\d+(?:\.\d+)?\s*%?|\.\d+\s*%?)"
_ACCURACY: Final = re.compile(rf"rate\s*(?:\+-|\+/-|±)\s*{_SHARE}")
_TEST: Final = re.compile(rf"rate\s*>=\s*{_SHARE}\s*vs\s*{_SHARE}(?:\s*errors\s*{_SHARE})?")
_BOUND: Final = re.compile(rf"rate\s*>=\s*{_SHARE}")
_FAILURES: Final = re.compile(r"(first|\d+)\s+failures?")
_COVERAGE: Final = re.compile(rf"coverage\s*(?:>=)?\s*{_SHARE}")
_FORMS: Final = (
    "`rate +- 2%`, `rate >= 0.95`, `rate >= 0.95 vs 0.90`, `first failure`, `10 failures` or `coverage 95%`"
)


def parse_rule(text: str) -> Rule:
    """Parse a stopping rule.

    Raises:
        UsageError: The rule is invalid.
    """
    stripped = " ".join(text.split())
    if found := _ACCURACY.fullmatch(stripped):
        half_width = _share(found[1])
        if not 0.0 < half_width < 0.5:
            raise _invalid(text, f"expected an accuracy between 0 and 50 %, found {found[1]}")
        return Accuracy(half_width)
    if found := _TEST.fullmatch(stripped):
        good, bad = _share(found[1]), _share(found[2])
        errors = _share(found[3]) if found[3] else ERRORS
        if not 0.0 < bad < good < 1.0:
            raise _invalid(text, "expected 0 < second rate < first rate < 1")
        if not 0.0 < errors < 0.5:
            raise _invalid(text, f"expected errors between 0 and 50 %, found {found[3]}")
        return RateTest(SequentialTest(good, bad, errors))
    if found := _BOUND.fullmatch(stripped):
        rate = _share(found[1])
        if not 0.0 < rate < 1.0:
            raise _invalid(text, f"expected a rate between 0 and 100 %, found {found[1]}")
        return RateBound(rate)
    if found := _FAILURES.fullmatch(stripped):
        count = 1 if found[1] == "first" else int(found[1])
        if not count:
            raise _invalid(text, "expected at least one failure")
        return Failures(count)
    if found := _COVERAGE.fullmatch(stripped):
        share = _share(found[1])
        if not 0.0 < share <= 1.0:
            raise _invalid(text, f"expected a coverage of more than 0 and at most 100 %, found {found[1]}")
        return CoverageGoal(share)
    raise _invalid(text, "unknown rule")


def _share(text: str) -> float:
    return float(text[:-1]) / 100.0 if text.endswith("%") else float(text)


def _invalid(text: str, reason: str) -> UsageError:
    return UsageError(f"invalid stopping rule `{text}`: {reason}", help=f"write {_FORMS}")
