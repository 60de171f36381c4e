"""Verbs about the simulator as a whole: worlds, time, snapshots, streams, recordings, faults and results."""

from __future__ import annotations

import json

from seoro.bridges import wire
from sim_nodes.outcomes import operation_failed
from sim_nodes.simulator import Simulator
from sim_nodes.trajectory_files import trajectory_files


def get_simulator_features(simulator: Simulator, _: wire.Empty) -> wire.SimulatorFeatures:
    return simulator.features()


def load_world(simulator: Simulator, request: wire.LoadWorld) -> wire.SimulatorFeatures:
    simulator.load(request.world, request.seed)
    return simulator.features()


def change_world(simulator: Simulator, request: wire.ChangeWorld) -> wire.SimulatorFeatures:
    simulator.change(request.world, request.robots)
    return simulator.features()


def unload_world(simulator: Simulator, _: wire.Empty) -> None:
    simulator.unload()


def set_simulation_state(simulator: Simulator, request: wire.SetSimulationState) -> None:
    simulator.set_state(request.state, request.rate)


def step_simulation(simulator: Simulator, request: wire.StepSimulation) -> wire.SimulationTime:
    return wire.SimulationTime(time=simulator.step(request.steps))


def reset_simulation(simulator: Simulator, request: wire.ResetSimulation) -> None:
    simulator.reset(request.scope)


def advance(simulator: Simulator, request: wire.Advance) -> wire.Advanced:
    return simulator.advance(request.until, request.horizon, collects_feedback=request.collects_feedback)


def rewind(simulator: Simulator, request: wire.Rewind) -> wire.SimulationTime:
    return wire.SimulationTime(time=simulator.rewind(request.time))


def start_tracks(simulator: Simulator, request: wire.StartTracks) -> None:
    simulator.start_tracks(request.rate, request.scans)


def cancel_goal(simulator: Simulator, request: wire.CancelGoal) -> None:
    simulator.simulation.cancel_goal(request.id)


def cancel_watch(simulator: Simulator, request: wire.CancelWatch) -> wire.CancelledWatch:
    return wire.CancelledWatch(margin=simulator.simulation.watches.cancel(request.id))


def save_state(simulator: Simulator, _: wire.Empty) -> wire.Snapshot:
    return simulator.save()


def restore_state(simulator: Simulator, request: wire.RestoreState) -> wire.SimulatorFeatures:
    simulator.restore(request.snapshot, request.purpose, request.seed)
    return simulator.features()


def open_stream(simulator: Simulator, request: wire.OpenStream) -> None:
    simulator.streams.open(request, simulator.simulation)


def close_stream(simulator: Simulator, request: wire.StreamName) -> None:
    simulator.streams.close(request.id)


def await_events(simulator: Simulator, request: wire.AwaitEvents) -> wire.LoggedEvents:
    """Return the events so far; the caller defers requests that wait for events (`LongPolls`)."""
    if not 0.0 <= request.wait <= wire.LONGEST_WAIT:
        raise operation_failed(f"invalid wait of {request.wait} s; expected 0 to {wire.LONGEST_WAIT:g} s")
    return simulator.log.since(request.since)


def start_recording(simulator: Simulator, request: wire.StartRecording) -> None:
    simulator.simulation.recording.start(request)


def stop_recording(simulator: Simulator, _: wire.Empty) -> wire.RecordingEnd:
    film, error = simulator.simulation.recording.stop()
    return wire.RecordingEnd(film=film, error=error)


def inject_fault(simulator: Simulator, request: wire.InjectFault) -> None:
    simulator.simulation.inject_fault(request.id, request.robot, request.device, request.fault, request.limit)


def clear_faults(simulator: Simulator, request: wire.ClearFaults) -> None:
    simulator.simulation.faults_of(request.robot).clear(request.device, request.kind)


def get_artifacts(simulator: Simulator, _: wire.Empty) -> wire.Artifacts:
    # These imports take half a second and are rarely needed.
    from sim_nodes.run_plot import top_down  # noqa: PLC0415

    simulation = simulator.simulation
    picture = wire.Artifact(
        name="top_down.png",
        media_type="image/png",
        description=f"The world {simulation.world.name} from above, with the paths of everything that moved",
        data=top_down(simulation),
    )
    measured = wire.Artifact(
        name="measurements.json",
        media_type="application/json",
        description="measurements of the robots",
        data=(json.dumps(simulation.measurements().model_dump(), indent=2) + "\n").encode(),
    )
    trajectories = trajectory_files(simulation.run_data.trajectories, simulation.time_of_tick)
    return wire.Artifacts(artifacts=(picture, measured, *trajectories))


def get_measurements(simulator: Simulator, _: wire.Empty) -> wire.Measurements:
    return simulator.simulation.measurements()
