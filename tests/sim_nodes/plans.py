"""Plans of the default planner."""

from __future__ import annotations

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.contracts import Path, PlanRequest, Setup
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.planner import GridPlanner
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import MobileDeclaration


def setup_for(known: NavigationMap, declaration: MobileDeclaration = BASE) -> Setup:
    return Setup(declaration, known, {}, Noise(0, "test"))


def plan_to(
    known: NavigationMap, start: tuple[float, float], goal: tuple[float, float], clearance: float = 0.18
) -> Path | None:
    declaration = BASE.model_copy(update={"clearance": clearance})
    request = PlanRequest(known.grid, known.distance, Pose2(*start, 0.0), Pose2(*goal, 0.0), 0)
    return GridPlanner(setup_for(known, declaration)).plan(request)
