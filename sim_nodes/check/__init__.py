"""Does an engine keep the contract of `sim_nodes.physics.Engine`? For the tests of engines, ours and others'.

    from sim_nodes.check import check_physics

    def test_my_engine():
        check_physics(MyEngine)

It knows an engine by the protocol only. Rules are functions; the first line of a docstring is what has to hold.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from types import ModuleType

from sim_nodes.check import arms, bodies, contacts, pictures, rays, repeating, robots, saving
from sim_nodes.check.bench import Make
from sim_nodes.lacking import WithoutArms, WithoutDynamics, WithoutPictures
from sim_nodes.physics import Engine, Rewinds, SavesState

__all__ = ["OPTIONAL", "RULES", "check_physics", "check_rule", "rules_for"]

Rule = Callable[[Make], None]

RULES: tuple[Rule, ...] = (
    repeating.steps_fit_into_ticks,
    bodies.what_is_set_is_what_is_found,
    bodies.bodies_fall_with_gravity,
    bodies.bodies_may_be_fast,
    bodies.bodies_turn_about_their_centre_of_mass,
    bodies.bodies_on_the_floor_stay_at_rest,
    bodies.friction_stops_what_slides,
    bodies.static_bodies_bear_loads_and_do_not_move,
    bodies.adding_and_removing_leaves_the_rest_alone,
    bodies.a_body_may_have_many_parts,
    robots.robots_stand_level_and_still,
    robots.wheels_turn_as_commanded,
    robots.robots_drive_straight,
    robots.robots_turn_in_place,
    robots.robots_stop_when_told_to,
    robots.robots_obey_their_own_commands_only,
    robots.wheels_without_power_roll_freely,
    robots.a_reset_brings_power_back,
    robots.a_robot_that_is_put_somewhere_rests_there,
    rays.rays_end_at_walls,
    rays.rays_start_where_the_robot_is,
    rays.rays_end_at_every_shape,
    rays.robots_do_not_see_themselves,
    rays.robots_see_each_other,
    rays.rays_see_changes_before_the_next_step,
    arms.arms_stay_where_they_are,
    arms.joints_go_where_they_are_pulled,
    arms.joints_follow_positions_that_move,
    arms.motors_bear_the_weight,
    arms.fingers_press_with_the_force,
    arms.what_is_gripped_is_carried,
    arms.arms_overlap_where_their_joints_put_them,
    arms.arms_overlap_the_floor_and_themselves,
    arms.thinking_changes_nothing,
    arms.a_reset_puts_arms_home,
    contacts.contacts_name_both,
    contacts.robots_touch_walls_and_each_other,
    contacts.robots_touch_where_they_are,
    contacts.what_is_near_does_not_touch,
    contacts.overlaps_are_found_for_every_shape,
    contacts.what_rests_on_something_does_not_overlap_it,
    pictures.links_are_where_they_are_mounted,
    pictures.pictures_show_what_is_where,
    pictures.pictures_show_the_present,
    pictures.pictures_change_nothing,
    repeating.many_steps_are_as_single_ones,
    repeating.many_steps_end_where_contacts_change,
    repeating.equal_runs_are_equal_to_the_bit,
    repeating.building_forgets_everything,
    repeating.a_reset_puts_everything_back,
    repeating.resets_do_not_drift,
    repeating.no_state_is_not_a_number,
)

# What not every engine offers, and the rules for those that do.
OPTIONAL: tuple[tuple[type, tuple[Rule, ...]], ...] = (
    (
        SavesState,
        (
            saving.what_is_restored_goes_on_as_it_did,
            saving.saving_changes_nothing,
            saving.what_was_added_since_is_gone_again,
            saving.a_restored_engine_resets_as_any_other,
            saving.arms_that_are_restored_go_on_as_they_did,
        ),
    ),
    (Rewinds, (saving.what_is_rewound_goes_on_as_it_did, saving.arms_that_are_rewound_go_on_as_they_did)),
)

ARMS_SAVED: tuple[Rule, ...] = (
    saving.arms_that_are_restored_go_on_as_they_did,
    saving.arms_that_are_rewound_go_on_as_they_did,
)

DYNAMICS: tuple[Rule, ...] = (
    bodies.bodies_fall_with_gravity,
    bodies.bodies_may_be_fast,
    bodies.bodies_turn_about_their_centre_of_mass,
    bodies.friction_stops_what_slides,
    bodies.static_bodies_bear_loads_and_do_not_move,
    robots.wheels_without_power_roll_freely,
    contacts.contacts_name_both,
    repeating.no_state_is_not_a_number,
)


def rules_for(engine: Engine) -> tuple[Rule, ...]:
    """The rules for what an engine offers (`sim_nodes.lacking`)."""
    rules = (*RULES, *(rule for kind, more in OPTIONAL if isinstance(engine, kind) for rule in more))
    left_out: set[Rule] = set(DYNAMICS) if isinstance(engine, WithoutDynamics) else set()
    if isinstance(engine, WithoutArms):
        of_saving = {
            saving.arms_that_are_restored_go_on_as_they_did,
            saving.arms_that_are_rewound_go_on_as_they_did,
        }
        left_out |= {*of_saving, *_of(arms, rules)}
    if isinstance(engine, WithoutPictures):
        left_out |= set(_of(pictures, rules))
    return tuple(rule for rule in rules if rule not in left_out)


def _of(module: ModuleType, rules: Iterable[Rule]) -> Iterator[Rule]:
    return (rule for rule in rules if rule.__module__ == module.__name__)


def check_physics(make: Callable[[], Engine]) -> None:
    """Check an engine by all rules for what it offers.

    Args:
        make: Makes an engine; it is called several times, and engines exist beside one another.

    Raises:
        AssertionError: A rule is broken; the message says which, what was found, and what was expected.
    """
    for rule in rules_for(make()):
        check_rule(rule, make)


def check_rule(rule: Rule, make: Callable[[], Engine]) -> None:
    """Check an engine by one of the rules.

    Raises:
        AssertionError: The rule is broken.
    """
    try:
        rule(make)
    except AssertionError as error:
        demand = (rule.__doc__ or rule.__name__).partition("\n")[0]
        raise AssertionError(f"{demand} But {error}") from error
