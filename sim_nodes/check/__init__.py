"""Conformance tests of engines: do they fulfil the contract `sim_nodes.physics.Engine`?

    from sim_nodes.check import check_physics

    def test_my_engine():
        check_physics(MyEngine)

They use an engine through the protocol only. Rules are functions; the first line of the docstring of a rule is its
requirement.
"""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

from sim_nodes.check import (
    arms,
    bodies,
    casting,
    driven_bodies,
    drives,
    repeating,
    robots,
    saving,
    sensing,
    terrain,
    work,
)
from sim_nodes.check.bench import Make
from sim_nodes.physics import DrivesBodies, Engine, MeasuresWork, Rewinds, SavesState
from sim_nodes.ray_bundles import CastsTogether
from sim_nodes.unsupported import WithoutArms, WithoutDynamics, WithoutRendering, WithoutTerrain

__all__ = ["OPTIONAL", "RENDERING", "RULES", "check_physics", "check_rule", "rules_for"]

Rule = Callable[[Make], None]


def _rules_of(*modules: ModuleType) -> tuple[Rule, ...]:
    """Return the rules of modules, in order: the public functions of type `Rule`."""
    return tuple(
        value
        for module in modules
        for name, value in vars(module).items()
        if not name.startswith("_") and getattr(value, "__annotations__", {}) == {"make": "Make", "return": "None"}
    )


RULES = _rules_of(repeating, bodies, robots, drives, terrain, sensing, arms)
REWINDING: tuple[Rule, ...] = (
    saving.rewound_engines_continue_identically,
    saving.rewound_arms_continue_identically,
)

# Rules for optional parts of engines.
OPTIONAL: tuple[tuple[type, tuple[Rule, ...]], ...] = (
    (SavesState, tuple(rule for rule in _rules_of(saving) if rule not in REWINDING)),
    (Rewinds, REWINDING),
    (DrivesBodies, _rules_of(driven_bodies)),
    (MeasuresWork, _rules_of(work)),
    (CastsTogether, _rules_of(casting)),
)

DYNAMICS: tuple[Rule, ...] = (
    bodies.bodies_fall_with_gravity,
    bodies.bodies_keep_high_velocities,
    bodies.bodies_turn_about_their_centre_of_mass,
    bodies.friction_stops_sliding_bodies,
    bodies.static_bodies_support_loads,
    robots.wheels_without_power_roll_freely,
    drives.planar_drives_stop_without_power,
    terrain.robots_drive_over_terrain,
    bodies.contacts_name_both_bodies,
    repeating.diverged_states_are_reported,
)


RENDERING: tuple[Rule, ...] = (
    sensing.images_show_bodies_at_their_poses,
    sensing.images_show_the_present,
    sensing.rendering_changes_nothing,
    sensing.links_keep_their_mounts,
)
# Rules that engines without a part need not fulfil.
OMITTED: tuple[tuple[type, tuple[Rule, ...]], ...] = (
    (WithoutDynamics, DYNAMICS),
    (
        WithoutArms,
        (*_rules_of(arms), saving.restored_arms_continue_identically, saving.rewound_arms_continue_identically),
    ),
    (WithoutRendering, RENDERING),
    (WithoutTerrain, _rules_of(terrain)),
)


def rules_for(engine: Engine) -> tuple[Rule, ...]:
    """Return the rules for the parts that an engine has (`sim_nodes.unsupported`)."""
    omitted = {rule for part, rules in OMITTED if isinstance(engine, part) for rule in rules}
    optional = (rule for part, rules in OPTIONAL if isinstance(engine, part) for rule in rules)
    return tuple(rule for rule in (*RULES, *optional) if rule not in omitted)


def check_physics(make: Callable[[], Engine]) -> None:
    """Check an engine by all rules for its features.

    Args:
        make: Factory of engines. It is called several times; engines exist side by side.

    Raises:
        AssertionError: The engine breaks a rule; the message gives the rule, the observation and the expectation.
    """
    for rule in rules_for(make()):
        check_rule(rule, make)


def check_rule(rule: Rule, make: Callable[[], Engine]) -> None:
    """Check an engine by one rule.

    Raises:
        AssertionError: The engine breaks the rule.
    """
    try:
        rule(make)
    except AssertionError as error:
        demand = (rule.__doc__ or rule.__name__).partition("\n")[0]
        raise AssertionError(f"{demand} But {error}") from error
