"""Planners and controllers by name: those of seoro, entry points of installed packages, and `module:Class`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import TypeVar

from seoro.bridges.wire.refusal import name_list
from sim_nodes.navigation.contracts import Controller, InvalidParameter, Planner, Plugin, Setup, UnsuitableRobot
from sim_nodes.navigation.controller import ArcController
from sim_nodes.navigation.cover import cover_of
from sim_nodes.navigation.holonomic import HolonomicController
from sim_nodes.navigation.hybrid import HybridPlanner
from sim_nodes.navigation.planner import GridPlanner
from sim_nodes.navigation.pursuit import PursuitController
from sim_nodes.outcomes import operation_failed
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.navigation import PluginDeclaration

PLANNERS: Mapping[str, type[Planner]] = {"grid": GridPlanner, "hybrid": HybridPlanner}
CONTROLLERS: Mapping[str, type[Controller]] = {
    "arcs": ArcController,
    "holonomic": HolonomicController,
    "pursuit": PursuitController,
}

P = TypeVar("P", bound=Plugin)


def default_plugins(declaration: MobileDeclaration) -> tuple[PluginDeclaration, PluginDeclaration]:
    """Return the planner and controller of a robot: those of its parameters, or by its drive and outline.

    Raises:
        RequestRefused: The controller cannot follow paths of the planner.
    """
    drive, declared = declaration.drive, declaration.navigation
    steers, slides = drive.min_turning_radius > 0.0, drive.max_lateral_speed > 0.0
    is_round = cover_of(declaration).is_round
    planner = declared.planner or PluginDeclaration(plugin="grid" if is_round and not steers else "hybrid")
    needs_headings = steers or planner.plugin == "hybrid"
    controller = "holonomic" if slides else "pursuit" if needs_headings else "arcs"
    chosen = declared.controller or PluginDeclaration(plugin=controller)
    if chosen.plugin == "arcs" and planner.plugin == "hybrid" and not is_round:
        raise operation_failed(
            f"the controller 'arcs' keeps a circle of {declaration.clearance:.2f} m free, the planner 'hybrid' "
            f"the outline only; expected the controller {controller!r}, or the planner 'grid'"
        )
    return planner, chosen


def find_planner(name: str) -> type[Planner]:
    """Return a planner by name.

    Raises:
        RequestRefused: It is unknown, cannot be imported, or is not a planner.
    """
    return _find(name, "planner", Planner, PLANNERS)


def find_controller(name: str) -> type[Controller]:
    """Return a controller by name.

    Raises:
        RequestRefused: It is unknown, cannot be imported, or is not a controller.
    """
    return _find(name, "controller", Controller, CONTROLLERS)


def make_plugin(kind: type[P], name: str, setup: Setup) -> P:
    """Make a planner or controller.

    Args:
        kind: Its class.
        name: Its name, for messages.
        setup: Robot, map and parameters.

    Raises:
        RequestRefused: Its parameters are invalid, or it cannot navigate the robot.
    """
    try:
        return kind(setup)
    except InvalidParameter as error:
        raise operation_failed(f"invalid parameters of the navigation plugin {name!r}: {error}") from error
    except UnsuitableRobot as error:
        raise operation_failed(f"the navigation plugin {name!r} does not suit the robot: {error}") from error


def _find(name: str, role: str, base: type[P], own: Mapping[str, type[P]]) -> type[P]:
    if name in own:
        return own[name]
    found = _import(name, role) if ":" in name else _entry_point(name, role, own)
    if not (isinstance(found, type) and issubclass(found, base)):
        raise operation_failed(
            f"{name!r} is not a {role}; expected a class below sim_nodes.navigation.contracts.{base.__name__}"
        )
    return found


def _import(name: str, role: str) -> object:
    module, _, attribute = name.partition(":")
    return _load(lambda: getattr(import_module(module), attribute), name, role)


def _entry_point(name: str, role: str, own: Mapping[str, type[P]]) -> object:
    group = f"seoro.navigation.{role}s"
    known = {point.name: point for point in entry_points(group=group)}
    if name not in known:
        raise operation_failed(
            f"unknown {role} {name!r} (known: {name_list({*own, *known})}); expected one of them, an entry point "
            f"of the group {group}, or module:Class"
        )
    return _load(known[name].load, name, role)


def _load(load: Callable[[], object], name: str, role: str) -> object:
    try:
        return load()
    except Exception as error:  # code of others, which may raise anything
        raise operation_failed(f"cannot import the {role} {name!r}: {type(error).__name__}: {error}") from error
