"""Verbs about where robots believe to be."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from seoro.bridges.wire.refusal import check_id
from sim_nodes.messages import flat_pose
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling
from sim_nodes.watches import LocalisationWatch


def _reinitialize(simulator: Simulator, request: wire.LocalisedRobot) -> Empty:
    simulator.simulation.search_pose(request.robot)
    return Empty()


def _watch(simulator: Simulator, request: wire.WatchLocalization) -> Empty:
    check_id(request.id)
    simulation = simulator.simulation
    simulation.watch(request.id, LocalisationWatch(simulation.robot(request.robot).mobile.name))
    return Empty()


def _get(simulator: Simulator, request: wire.LocalisedRobot) -> wire.Localization:
    simulation = simulator.simulation
    base = simulation.robot(request.robot).mobile
    pose, estimate = base.localised_pose(), base.localisation.estimate
    if pose is None or estimate is None:
        return wire.Localization(
            pose=None, covariance=None, particles=len(base.localisation.particles), error=None
        )
    truth = simulation.true_pose(request.robot)
    return wire.Localization(
        pose=flat_pose(pose),
        covariance=tuple(estimate.covariance.ravel().tolist()),
        particles=len(base.localisation.particles),
        error=pose.distance(truth.x, truth.y),
    )


HANDLERS: tuple[Handling, ...] = (
    (wire.REINITIALIZE_GLOBAL_LOCALIZATION, _reinitialize),
    (wire.WATCH_LOCALIZATION, _watch),
    (wire.GET_LOCALIZATION, _get),
)
