"""Verbs that tell what there is."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Category, Empty, Result
from sim_nodes.messages import entity_state, flat_pose
from sim_nodes.physics import BodyState
from sim_nodes.refusal import RequestRefused
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.checks import check_finite
from sim_nodes.verbs.handling import Handling
from sim_nodes.worlds.loader import available_worlds


def _get_entities_states(simulator: Simulator, request: wire.StateFilter) -> wire.EntityStates:
    entities = simulator.simulation.entities
    unknown = [number for number in request.categories if number not in list(Category)]
    if unknown:
        known = ", ".join(f"{each.value} ({each.name.lower()})" for each in Category)
        raise RequestRefused(Result.OPERATION_FAILED, f"there is no category {unknown[0]}: known are {known}")
    if request.bounds is not None:
        low, high = request.bounds.lower, request.bounds.upper
        check_finite("bounds", low.x, low.y, low.z, high.x, high.y, high.z)
    found = {
        name: state
        for name in entities.matching(request.filter)
        if not request.categories or entities.category(name) in request.categories
        for state in [entities.state(name)]
        if request.bounds is None or _is_in(request.bounds, state)
    }
    return wire.EntityStates(names=tuple(found), states=tuple(map(entity_state, found.values())))


def _is_in(bounds: wire.Bounds, state: BodyState) -> bool:
    low, high = bounds.lower, bounds.upper
    x, y, z = state.position
    return low.x <= x <= high.x and low.y <= y <= high.y and low.z <= z <= high.z


def _get_entity_info(simulator: Simulator, request: wire.EntityName) -> wire.EntityInfo:
    entities = simulator.simulation.entities
    return wire.EntityInfo(
        category=entities.category(request.name), description=entities.description(request.name)
    )


def _get_entity_bounds(simulator: Simulator, request: wire.EntityName) -> wire.EntityBounds:
    box = simulator.simulation.entities.bounds(request.name)
    if box is None:
        return wire.EntityBounds(bounds=None)
    lower, upper = (wire.Vector3(x=x, y=y, z=z) for x, y, z in (box.lower.tolist(), box.upper.tolist()))
    return wire.EntityBounds(bounds=wire.Bounds(lower=lower, upper=upper))


def _get_current_world(simulator: Simulator, _: Empty) -> wire.CurrentWorld:
    return wire.CurrentWorld(name=simulator.simulation.world.name, source=simulator.source)


def _get_available_worlds(_: Simulator, __: Empty) -> wire.AvailableWorlds:
    return wire.AvailableWorlds(names=available_worlds())


def _get_simulation_state(simulator: Simulator, _: Empty) -> wire.CurrentState:
    return wire.CurrentState(state=simulator.state, time=simulator.time)


def _get_transforms(simulator: Simulator, _: Empty) -> wire.Transforms:
    poses = {name: simulator.simulation.pose(name) for name in simulator.simulation.frames.names}
    return wire.Transforms(
        transforms=tuple(
            wire.Transform(frame=name, pose=None if pose is None else flat_pose(pose))
            for name, pose in poses.items()
        )
    )


HANDLERS: tuple[Handling, ...] = (
    (wire.GET_ENTITIES_STATES, _get_entities_states),
    (wire.GET_ENTITY_INFO, _get_entity_info),
    (wire.GET_ENTITY_BOUNDS, _get_entity_bounds),
    (wire.GET_CURRENT_WORLD, _get_current_world),
    (wire.GET_AVAILABLE_WORLDS, _get_available_worlds),
    (wire.GET_SIMULATION_STATE, _get_simulation_state),
    (wire.GET_TRANSFORMS, _get_transforms),
)
