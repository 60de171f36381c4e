"""Entities of a world, which are spawned, moved and deleted."""

from __future__ import annotations

import re
from collections.abc import Sequence

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes.agents.agent import Agent
from sim_nodes.departures import is_within
from sim_nodes.extents import FLOOR_TOLERANCE, lowest_point
from sim_nodes.files import NAME
from sim_nodes.geometry import Vector
from sim_nodes.known_entities import KnownEntities, placed
from sim_nodes.models.scenes import SceneBody
from sim_nodes.outcomes import feature_unsupported, operation_failed
from sim_nodes.physics import BodyModel, BodyState, ManyBodies
from sim_nodes.spawning import Spawned, SpawnRequest, first_free, placed_bodies
from sim_nodes.terrain.placing import lift_onto, raised, standing
from sim_nodes.views import Lens

MAX_SPAWNED = 1000
RESERVED = frozenset({"floor", "map", "odom", "base_link", "world"})


class Entities(KnownEntities):
    """The entities of a world, with changes."""

    def spawn(self, request: SpawnRequest, time: float) -> str:
        """Spawn a body; returns its name, which may differ from the requested one with `rename`.

        Raises:
            RequestRefused: The name is in use or invalid, or the body would overlap something.
        """
        [result] = self.spawn_all([request], time)
        if isinstance(result, RequestRefused):
            raise result
        return result

    def spawn_all(self, requests: Sequence[SpawnRequest], time: float) -> list[str | RequestRefused]:
        """Spawn bodies in order, each as if the earlier ones existed; returns names or refusals."""
        results: list[str | RequestRefused] = []
        added: list[tuple[str, BodyModel, BodyState]] = []
        for request in requests:
            try:
                bodies = self._accept(request, time)
            except RequestRefused as refused:
                results.append(refused)
            else:
                results.append(next(iter(bodies)))
                added += [(name, model, state) for name, (model, state) in bodies.items()]
        if added:
            self._add(added)
        self._remove_overlapping(results, requests)
        return results

    def _accept(self, request: SpawnRequest, time: float) -> dict[str, tuple[BodyModel, BodyState]]:
        """Check and register bodies without the engine; returns them by name, the one of the request first."""
        name = self._free_name(request.name, request.rename)
        if len(self.spawned) + len(request.bodies) > MAX_SPAWNED:
            raise operation_failed(f"too many spawned entities: {MAX_SPAWNED} at most; delete some")
        bodies = placed_bodies(name, request.bodies, request.state, self.names())
        for each, (model, state) in bodies.items():
            _check_floor(each, model, state)
        ground = self._world.ground
        lift = max(lift_onto(ground, model, state) for model, state in bodies.values())
        bodies = {each: (model, raised(state, lift)) for each, (model, state) in bodies.items()}
        for each, (model, _) in bodies.items():
            self.spawned[each] = Spawned(model, time, request.tags, "" if each == name else name)
        return bodies

    def scene_of(self, name: str) -> tuple[str, ...]:
        """Return the names of a spawned body and of the others in its file, if it is the first of them."""
        return (name, *(each for each, body in self.spawned.items() if body.scene == name))

    def _remove_overlapping(self, results: list[str | RequestRefused], requests: Sequence[SpawnRequest]) -> None:
        """Remove bodies that overlap entities or earlier bodies, and the others in their files."""
        later = {each for name in results if isinstance(name, str) for each in self.scene_of(name)}
        refused: list[str] = []
        for index, (name, request) in enumerate(zip(results, requests, strict=True)):
            if not isinstance(name, str):
                continue
            own = self.scene_of(name)
            ignored = later | set(refused) | set(own)
            found = {each: set(self._engine.overlaps(each)) - ignored for each in own}
            later -= set(own)
            overlapping = set().union(*found.values())
            if overlapping:
                what = next(each for each, others in found.items() if others)
                shown = placed(name, request.state) if what == name else repr(what)
                results[index] = RequestRefused(
                    SpawnResult.INVALID_POSE, f"{shown} would overlap {name_list(overlapping)}"
                )
                refused += own
        self._remove(refused)

    def _add(self, bodies: Sequence[tuple[str, BodyModel, BodyState]]) -> None:
        try:
            if isinstance(self._engine, ManyBodies):
                self._engine.add_bodies(bodies)
            else:
                for name, model, state in bodies:
                    self._engine.add_body(name, model, state)
        except BaseException:
            for name, _, _ in bodies:
                del self.spawned[name]
            raise

    def _remove(self, names: Sequence[str]) -> None:
        """Remove spawned bodies."""
        if not names:
            return
        if isinstance(self._engine, ManyBodies):
            self._engine.remove_bodies(names)
        else:
            for name in names:
                self._engine.remove_body(name)
        for name in names:
            del self.spawned[name]
            self.agents.pop(name, None)
            self._infos.pop(name, None)

    def spawn_camera(self, name: str, lens: Lens, place: BodyState) -> str:
        """Spawn a free camera; returns its name.

        Raises:
            RequestRefused: The name is in use or invalid, or there are too many cameras.
        """
        name = self._free_name(name, rename=False)
        self.cameras.add(name, lens, place)
        return name

    def follow(self, camera: str, entity: str, offset: Vector) -> None:
        """Make a free camera follow a robot or a body.

        Raises:
            RequestRefused: The camera or entity is unknown, or the entity never moves.
        """
        self._check_known(entity)
        if entity in self._walls | self.cameras.free:
            raise feature_unsupported(f"cameras follow robots and bodies; {entity!r} is neither")
        self.cameras.follow(camera, entity, offset)

    def spawn_agent(self, name: str, agent: Agent, time: float) -> None:
        """Spawn a person at its initial pose.

        Raises:
            RequestRefused: See `spawn`.
        """
        body = SceneBody("body", agent.model, BodyState((0.0, 0.0, 0.0)))
        self.spawn(SpawnRequest(name, (body,), agent.state, rename=False, tags=agent.tags), time)
        self.agents[name] = agent

    def _free_name(self, name: str, rename: bool) -> str:
        if not re.fullmatch(NAME, name) or name in RESERVED:
            raise RequestRefused(
                SpawnResult.NAME_INVALID,
                f"invalid name {name!r}; expected letters, digits, '_' and '-', a letter first, at most 64, "
                f"and not {name_list(RESERVED)}",
            )
        used = self.names()
        if name in used and not rename:
            raise RequestRefused(
                SpawnResult.NAME_NOT_UNIQUE, f"duplicate name {name!r} of an entity; in use: {name_list(used)}"
            )
        return first_free(name, used)

    def move(self, name: str, state: BodyState) -> None:
        """Set the state of a robot, prop, spawned body or free camera; one in terrain is put on it.

        Raises:
            RequestRefused: The entity is unknown or cannot move, or it would overlap something.
        """
        self._check_known(name)
        if name in self._walls:
            raise feature_unsupported(f"{name!r} cannot be moved: it is a wall of the world")
        if name in self.built_in:
            kind = self.kind_of_part(name)
            raise feature_unsupported(f"{name!r} cannot be placed: it is a {kind}; move it by `move_{kind}`")
        if name in self._robots and self._robots[name].declaration.fixed:
            raise feature_unsupported(f"{name!r} cannot be moved: it is fixed to the world")
        if name in self.cameras.free:
            self.cameras.set_mount(name, state)
            return
        if name in self.bodies:
            _check_floor(name, self.bodies[name], state)
            state = raised(state, lift_onto(self._world.ground, self.bodies[name], state))
        elif not is_within(state.position, self._world.extent):
            raise operation_failed(f"{placed(name, state)} would be outside of the world")
        else:
            state = standing(self._world.ground, self._robots[name].declaration, state)
        before = self._engine.body_state(name)
        self._engine.set_body_state(name, state)
        overlapping = self._engine.overlaps(name)
        if overlapping and state.position != before.position:
            self._engine.set_body_state(name, before)
            raise operation_failed(f"{placed(name, state)} would overlap {name_list(overlapping)}")

    def delete(self, name: str) -> None:
        """Delete a spawned entity; with the first body of a file, the others of the file are deleted.

        Raises:
            RequestRefused: The entity was not spawned.
        """
        self._check_known(name)
        if name in self.cameras.free:
            self.cameras.remove(name)
            self._infos.pop(name, None)
            return
        if name not in self.spawned:
            raise operation_failed(
                f"{name!r} belongs to the world; only spawned entities can be deleted: {name_list(self.spawned)}"
            )
        names = self.scene_of(name)
        for each in names:
            self.cameras.unfollow(each)
        self._remove(names)

    def delete_all(self) -> None:
        """Delete all spawned entities."""
        for name in self.spawned:
            self.cameras.unfollow(name)
        self._remove(tuple(self.spawned))
        self.cameras.remove_spawned()
        self._infos = {name: info for name, info in self._infos.items() if name in self.names()}


def _check_floor(name: str, model: BodyModel, state: BodyState) -> None:
    lowest = lowest_point(model, state)
    if lowest < -FLOOR_TOLERANCE:
        needed = state.position[2] - lowest
        raise RequestRefused(
            SpawnResult.INVALID_POSE,
            f"{placed(name, state)} would be {-lowest:.3f} m below the floor; "
            f"expected z of {needed:.3f} m or more",
        )
