"""Levels of conformance: of simulator nodes from a clock to robots that navigate, and of bridges."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType

from seoro.bridges.conformance.bench import RULES, Rule, SimulatedBackend, has
from seoro.bridges.conformance.bridge_arms import HANDLING
from seoro.bridges.conformance.bridge_navigation import NAVIGATING
from seoro.bridges.conformance.bridges import DRIVING, HOLDING, BridgeRule
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots
from seoro.runtime.contracts.worlds import Frames, Simulation

LEVELS: Mapping[str, tuple[type, ...]] = MappingProxyType(
    {
        "time": (),
        "drive": (Frames, DrivenRobots),
        "entities": (Frames, DrivenRobots, Simulation),
        "navigate": (Frames, DrivenRobots, Simulation, MobileRobots),
    }
)
"""Contracts that each level requires, from the lowest level on."""


BRIDGE_LEVELS: Mapping[str, tuple[BridgeRule, ...]] = MappingProxyType(
    {
        "hold": HOLDING,
        "drive": (*HOLDING, *DRIVING),
        "navigate": (*HOLDING, *DRIVING, *NAVIGATING),
        "arm": (*HOLDING, *HANDLING),
    }
)
"""Rules of each level of bridges."""

MOTIONS: Mapping[str, str] = MappingProxyType(
    {
        "drive": "will drive ahead by 15 cm",
        "navigate": "will drive up to 50 cm ahead and back, also turning",
        "arm": "will turn the first joint of its arm by 3 degrees and back, and open and close its gripper",
    }
)
"""Motions of a robot at the levels of bridges that move it."""


def checked_contracts() -> tuple[type, ...]:
    """Return all contracts that rules require, in the order of the rules."""
    return tuple(dict.fromkeys(contract for needed in RULES.values() for contract in needed))


def rules_of(contracts: Collection[type]) -> tuple[Rule, ...]:
    """Return the rules that require no other contracts."""
    return tuple(rule for rule, needed in RULES.items() if set(needed) <= set(contracts))


def unsupported(backend: SimulatedBackend, contracts: Collection[type]) -> tuple[type, ...]:
    """Return the contracts that a backend does not support."""
    return tuple(contract for contract in contracts if not has(backend, contract))


def highest_level(backend: SimulatedBackend) -> str:
    """Return the highest level of which a backend supports all contracts."""
    return [level for level, contracts in LEVELS.items() if not unsupported(backend, contracts)][-1]
