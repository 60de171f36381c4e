from __future__ import annotations

from functools import partial

import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check import OPTIONAL, RULES, Rule, check_rule, rules_for
from tests.sim_nodes.engines import make_engine

ALL = (*RULES, *(rule for _, rules in OPTIONAL for rule in rules))
LONG = "resets_do_not_drift"  # in PyBullet
CASES = [
    pytest.param(engine, rule, marks=pytest.mark.more if (engine, rule.__name__) == ("pybullet", LONG) else ())
    for engine in ENGINES
    for rule in ALL
]


@pytest.mark.parametrize(
    ("engine", "rule"), CASES, ids=lambda value: value if isinstance(value, str) else value.__name__
)
def test_engines_fulfil_the_rules(engine: str, rule: Rule) -> None:
    if rule not in rules_for(make_engine(engine)):
        pytest.skip(f"it is a rule for what the engine {engine} does not offer")
    check_rule(rule, partial(make_engine, engine))
