"""Rules of conformance, from their docstrings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from seoro.bridges.conformance import BRIDGE_LEVELS, LEVELS, Rule, checked_contracts, requirement, rules_of
from tests.tools.reference.tables import code, table


def simulator_rules() -> str:
    """Return a table of the rules of simulators, each at its lowest level."""
    levels = {level: rules_of(contracts) for level, contracts in LEVELS.items()}
    return _table({**levels, "all": rules_of(checked_contracts())})


def bridge_rules() -> str:
    """Return a table of the rules of bridges, each at its lowest level."""
    return _table(BRIDGE_LEVELS)


def _table(levels: Mapping[str, Sequence[Rule]]) -> str:
    return table(("level", "rule", "code"), _rows(levels))


def _rows(levels: Mapping[str, Sequence[Rule]]) -> Iterator[tuple[str, str, str]]:
    shown: set[Rule] = set()
    for level, rules in levels.items():
        for rule in rules:
            if rule not in shown:
                shown.add(rule)
                yield code(level), requirement(rule), code(rule.__name__)
