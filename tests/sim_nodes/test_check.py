"""The rules for engines find engines that break them: each engine here has one defect."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sim_nodes.check import (
    OPTIONAL,
    RULES,
    Rule,
    bodies,
    check_physics,
    check_rule,
    repeating,
    robots,
    saving,
    sensing,
)
from sim_nodes.check.bench import ROBOT
from sim_nodes.geometry import Array, Quaternion, Vector
from sim_nodes.physics import BodyModel, BodyState, ContactPoint, Scene, UnstablePhysics
from sim_nodes.views import NoRendering, Picture, View
from tests.sim_nodes.engines import expect_broken, needs_pictures

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

from sim_nodes.mujoco.engine import MujocoEngine


class Deaf(MujocoEngine):
    def touching(self) -> frozenset[tuple[str, str]]:
        return frozenset()


class Numb(MujocoEngine):
    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        return ()


class Misplaced(MujocoEngine):
    """It returns the position of the robot instead of the contact point."""

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        place = self.body_state(name).position
        return tuple(replace(point, position=place) for point in super().contact_points(name))


class Reversed(MujocoEngine):
    """Its normals point from the other to the robot."""

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        found = super().contact_points(name)
        return tuple(replace(point, normal=(-x, -y, -z)) for point in found for x, y, z in [point.normal])


class Selfish(MujocoEngine):
    """It names the robot instead of the entity that touches it."""

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        return tuple(replace(point, entity=name) for point in super().contact_points(name))


class Unsorted(MujocoEngine):
    def touching(self) -> frozenset[tuple[str, str]]:
        return frozenset((b, a) for a, b in super().touching())


class Careless(MujocoEngine):
    def overlaps(self, name: str) -> tuple[str, ...]:
        return ()


class Fast(MujocoEngine):
    """Its wheels are 3 % too large, as wheels made of hulls."""

    def command_wheels(self, robot: str, *targets: float) -> None:
        super().command_wheels(robot, *(1.04 * target for target in targets))


class Swapped(MujocoEngine):
    def command_wheels(self, robot: str, *targets: float) -> None:
        super().command_wheels(robot, *reversed(targets))


class Shared(MujocoEngine):
    """Commands are for all robots."""

    def command_wheels(self, robot: str, *targets: float) -> None:
        for name in self._drives:
            super().command_wheels(name, *targets)


class Tireless(MujocoEngine):
    def power_wheels(self, robot: str, on: bool) -> None:
        return


class Braked(MujocoEngine):
    """Its wheels are held when they have no power."""

    def power_wheels(self, robot: str, on: bool) -> None:
        self.command_wheels(robot, 0.0, 0.0)
        self._off = not on

    def command_wheels(self, robot: str, *targets: float) -> None:
        if not getattr(self, "_off", False):
            super().command_wheels(robot, *targets)


class Forgetful(MujocoEngine):
    """Adding a body switches power on."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        self._without_power.clear()
        super().add_body(name, model, state)


class ShortSighted(MujocoEngine):
    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        return super().cast_rays(robot, link, directions, limit) - 0.02


class Boundless(MujocoEngine):
    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        return super().cast_rays(robot, link, directions, 100.0)


class Vain(MujocoEngine):
    """It sees itself."""

    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        return np.minimum(super().cast_rays(robot, link, directions, limit), 0.1)


class Stubborn(MujocoEngine):
    """Its resets restore nothing."""

    def reset(self) -> None:
        pass


class Drifting(MujocoEngine):
    def reset(self) -> None:
        super().reset()
        name = next(iter(self._drives))
        x, y, z = self.body_state(name).position
        self._resets = getattr(self, "_resets", 0) + 1
        self.set_body_state(name, BodyState((x + 1e-15 * self._resets, y, z)))


class Random(MujocoEngine):
    def step(self, count: int = 1) -> int:
        made = super().step(count)
        self._data.qvel[0] += np.random.default_rng().normal(0.0, 1e-12)
        return made


class Hoarding(MujocoEngine):
    """A new scene starts with the commands of the old one."""

    def build(self, scene: Scene) -> None:
        kept = self._data.ctrl.copy() if hasattr(self, "_data") else None
        super().build(scene)
        if kept is not None:
            self._data.ctrl[: len(kept)] = kept[: len(self._data.ctrl)]


class Meddling(MujocoEngine):
    """Adding a body disturbs others."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        super().add_body(name, model, state)
        self._data.qpos[0] += 1e-16 + abs(self._data.qpos[0]) * 1e-15


class Light(MujocoEngine):
    def build(self, scene: Scene) -> None:
        super().build(scene)
        self._model.opt.gravity[2] = self._spec.option.gravity[2] = -9.5


class Slippery(MujocoEngine):
    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        super().add_body(name, model, state)
        self._model.geom_friction[:, 0] *= 0.5


class Loose(MujocoEngine):
    """Its static bodies move."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        super().add_body(name, BodyModel(model.parts, model.mass, model.friction), state)


class Off(MujocoEngine):
    """It returns the centre of mass instead of the origin."""

    def body_state(self, name: str) -> BodyState:
        state = super().body_state(name)
        x, y, z = self._data.xipos[self._bases[name]].tolist()
        return BodyState((x, y, z), state.orientation, state.linear, state.angular)


class Even(MujocoEngine):
    """Parts have masses by volume, despite their own masses."""

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        parts = tuple(replace(part, mass=None) for part in model.parts)
        super().add_body(name, replace(model, parts=parts), state)


class Rolling(MujocoEngine):
    """Wheels of robots whose state is set keep turning."""

    def set_body_state(self, name: str, state: BodyState) -> None:
        speeds = self._data.qvel.copy()
        super().set_body_state(name, state)
        if name in self._drives:
            wheels = self._drives[name].wheel_angular_speeds
            self._data.qvel[wheels] = speeds[wheels]


class Hasty(MujocoEngine):
    """Many steps at once are fewer and longer ones."""

    def step(self, count: int = 1) -> int:
        timestep = self._model.opt.timestep
        self._model.opt.timestep = timestep * count
        made = super().step(1)
        self._model.opt.timestep = timestep
        return made * count


class Glancing(MujocoEngine):
    """It checks contacts only after the last of many steps."""

    def step(self, count: int = 1) -> int:
        for _ in range(count):
            super().step()
        return count


class Silent(MujocoEngine):
    """It does not report diverged states."""

    def step(self, count: int = 1) -> int:
        try:
            return super().step(count)
        except UnstablePhysics:
            return count


class Cold(MujocoEngine):
    """It does not save the warm start of its solver."""

    def restore(self, saved: Mapping[str, Any]) -> None:
        super().restore(saved)
        self._data.qacc_warmstart[:] = 0.0


class Littering(MujocoEngine):
    """Bodies of the earlier scene remain."""

    def restore(self, saved: Mapping[str, Any]) -> None:
        added = dict(self._added)
        super().restore(saved)
        for name, (model, state) in added.items():
            if name not in self._added:
                self.add_body(name, model, state)


class Mindless(MujocoEngine):
    """It does not save the power of motors."""

    def rewind(self, checkpoint: Mapping[str, Any]) -> None:
        super().rewind({**checkpoint, "without_power": set()})


class Onward(MujocoEngine):
    """It gives no checkpoint."""

    def checkpoint(self) -> Any:
        return None


class Nosy(MujocoEngine):
    """It makes a step before it saves."""

    def save(self) -> Mapping[str, Any]:
        self.step()
        return super().save()


class Settled(MujocoEngine):
    """It saves the present poses of bodies as their initial ones."""

    def restore(self, saved: Mapping[str, Any]) -> None:
        super().restore(saved)
        for name in self._added:
            x, y, z = self.body_state(name).position
            self._model.body(name).pos = self._spec.body(name).pos = (x, y, z)
            self._model.qpos0[:] = self._data.qpos


class Odd(MujocoEngine):
    steps_per_second = 240


class Mirrored(MujocoEngine):
    def render(self, view: View) -> Picture:
        return super().render(view)[:, ::-1]


class Wide(MujocoEngine):
    """It uses the vertical field of view horizontally."""

    def render(self, view: View) -> Picture:
        lens = view.lens
        fov = 2 * math.atan(math.tan(lens.fov / 2) / lens.aspect)
        return super().render(replace(view, lens=replace(lens, fov=fov)))


class Late(MujocoEngine):
    """It renders the previous image again."""

    def render(self, view: View) -> Picture:
        before = getattr(self, "_before", None)
        self._before = super().render(view)
        return self._before if before is None else before


class Shaken(MujocoEngine):
    """Rendering changes its state."""

    def render(self, view: View) -> Picture:
        self._data.qpos[0] += 1e-15
        return super().render(view)


class Behind(MujocoEngine):
    """Its links have their poses of one step before."""

    def step(self, count: int = 1) -> int:
        self._poses = {link: super(Behind, self).link_pose(ROBOT, link) for link in ("rplidar_link",)}
        for _ in range(10):
            super().step()
        return count

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        return self._poses[link]


class Blind(MujocoEngine):
    def render(self, view: View) -> Picture:
        raise NoRendering("there is nothing to draw with")


@pytest.mark.parametrize(
    ("make", "rule", "words"),
    [
        (Deaf, bodies.contacts_name_both_bodies, "gives the contacts none"),
        (Deaf, bodies.robots_touch_walls_and_each_other, "at a wall"),
        (Numb, bodies.contact_points_are_between_the_entities, "those of none"),
        (Misplaced, bodies.contact_points_are_between_the_entities, "ahead of"),
        (Reversed, bodies.contact_points_are_between_the_entities, "the normal of"),
        (Selfish, bodies.contact_points_are_between_the_entities, "the points of"),
        (Unsorted, bodies.contacts_name_both_bodies, "lower"),
        (Careless, bodies.overlaps_are_found_for_every_shape, "a box in a robot"),
        (Fast, robots.robots_drive_straight, "instead of 3: off by"),
        (Swapped, robots.robots_turn_in_place, "heading"),
        (Shared, robots.robots_ignore_commands_of_others, "without commands"),
        (Tireless, robots.wheels_without_power_roll_freely, "the velocity 5 s after"),
        (Braked, robots.wheels_without_power_roll_freely, "that is pushed"),
        (Forgetful, robots.wheels_without_power_roll_freely, "after a body was added"),
        (ShortSighted, sensing.rays_end_at_walls, "instead of"),
        (ShortSighted, sensing.rays_end_at_every_shape, "the ray to a box"),
        (Boundless, sensing.rays_end_at_walls, "limit of 1 m"),
        (Vain, sensing.robots_do_not_see_themselves, "the nearest at 0.100 m"),
        (Stubborn, repeating.a_reset_restores_everything, "the position of a robot"),
        (Drifting, repeating.resets_do_not_drift, "after reset 2"),
        (Random, repeating.equal_runs_are_bit_identical, "a second engine"),
        (Hoarding, repeating.building_replaces_everything, "with commands of an earlier scene"),
        (Meddling, bodies.adding_and_removing_changes_nothing_else, "adding another body changed robot"),
        (Light, bodies.bodies_fall_with_gravity, "the velocity of"),
        (Slippery, bodies.friction_stops_sliding_bodies, "slid"),
        (Loose, bodies.static_bodies_support_loads, "static body"),
        (Off, bodies.states_are_returned_as_set, "lopsided"),
        (Off, bodies.bodies_turn_about_their_centre_of_mass, "club"),
        (Even, bodies.bodies_turn_about_their_centre_of_mass, "club that is heavy at its end"),
        (Rolling, robots.a_robot_stays_where_its_state_is_set, ""),
        (Silent, repeating.diverged_states_are_reported, "no step raised"),
        (Mirrored, sensing.images_show_bodies_at_their_poses, "first and last row and column of a cube"),
        (Wide, sensing.images_show_bodies_at_their_poses, "first and last row and column of a cube"),
        (Late, sensing.images_show_the_present, "a cube that was moved"),
        (Shaken, sensing.rendering_changes_nothing, "rendering has changed the state at"),
        (Behind, sensing.links_keep_their_mounts, "of the lidar's link"),
        (Cold, saving.restored_engines_continue_identically, "another engine differs in observation"),
        (Littering, saving.restoring_removes_later_bodies, ""),
        (Nosy, saving.saving_changes_nothing, "an engine that was saved"),
        (Onward, saving.rewound_engines_continue_identically, "no checkpoint within 400 steps"),
        (Mindless, saving.rewound_engines_continue_identically, "an engine that was rewound"),
        (Settled, saving.restored_engines_reset_as_others, "a restored engine that was reset"),
        (Hasty, repeating.batches_equal_single_steps, ""),
        (Glancing, repeating.batches_end_where_contacts_change, "the first"),
        (Odd, repeating.steps_fit_into_ticks, "4.8 instead of 5"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_a_faulty_engine_breaks_a_rule(make: Callable[[], MujocoEngine], rule: Rule, words: str) -> None:
    if rule.__module__ == sensing.__name__:
        needs_pictures("mujoco")
    expect_broken(rule, make, words)


def test_an_engine_without_rendering_passes_the_rules_for_images() -> None:
    for rule in (sensing.images_show_bodies_at_their_poses, sensing.images_show_the_present):
        check_rule(rule, Blind)
    check_rule(sensing.rendering_changes_nothing, Blind)


def test_check_physics_raises_the_message_of_the_first_broken_rule() -> None:
    with pytest.raises(AssertionError, match=r"^An engine has a name, .* But the number of steps"):
        check_physics(Odd)


def test_each_rule_states_its_requirement() -> None:
    for rule in (*RULES, *(rule for _, rules in OPTIONAL for rule in rules)):
        demand = (rule.__doc__ or "").partition("\n")[0]
        assert demand.endswith("."), rule.__name__
