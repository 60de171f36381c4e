"""What is left at the end of a run."""

from __future__ import annotations

import json

from seoro.bridges import wire
from seoro.bridges.wire import Empty
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _get_artifacts(simulator: Simulator, _: Empty) -> wire.Artifacts:
    # Half a second of imports that a node needs only when it is asked for pictures.
    from sim_nodes.picture import top_down  # noqa: PLC0415

    simulation = simulator.simulation
    picture = wire.Artifact(
        name="top_down.png",
        media_type="image/png",
        description=f"The world {simulation.world.name} from above, with the ways of what moved",
        data=top_down(simulation),
    )
    measured = wire.Artifact(
        name="measurements.json",
        media_type="application/json",
        description="what was measured of the robots",
        data=(json.dumps(simulation.measurements().model_dump(), indent=2) + "\n").encode(),
    )
    return wire.Artifacts(artifacts=(picture, measured))


def _get_measurements(simulator: Simulator, _: Empty) -> wire.Measurements:
    return simulator.simulation.measurements()


HANDLERS: tuple[Handling, ...] = (
    (wire.GET_ARTIFACTS, _get_artifacts),
    (wire.GET_MEASUREMENTS, _get_measurements),
)
