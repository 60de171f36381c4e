"""Contracts of backends that simulate worlds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

from seoro.robotics.geometry import Pose3D, Velocity6D


@runtime_checkable
class Frames(Protocol):
    """A simulated world with frames; the true frame of a robot is called NAME_base_link_gt."""

    async def relative_pose(self, frame: str, parent_frame: str, distance: float) -> Pose3D:
        """Return the pose `distance` [m] ahead of a frame, in the parent frame."""


@runtime_checkable
class Simulation(Frames, Protocol):
    """A simulated world; terms of ROS `simulation_interfaces`."""

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """Spawn a model from the model path; return its actual name."""

    async def spawn_entities(self, entities: Sequence[tuple[str, str, Pose3D]]) -> None:
        """Spawn entities (name, model, pose) in order. A failure does not remove those already spawned."""

    async def delete_entity(self, name: str) -> None:
        """Delete an entity."""

    async def entities(self) -> tuple[str, ...]:
        """Return the names of all entities."""

    async def set_entity_state(self, name: str, pose: Pose3D, velocity: Velocity6D) -> None:
        """Set the pose and velocity of an entity."""

    async def step_simulation(self, steps: int) -> None:
        """Run physics steps while paused."""

    async def reset_simulation(self) -> None:
        """Reset every entity to its initial state and delete spawned entities; time goes on."""


@runtime_checkable
class Worlds(Protocol):
    """A simulator with several worlds."""

    async def change_world(self, world: str) -> None:
        """Continue in another world, in its initial state, given its name or the path of its file.

        The time of the run goes on. Active goals end as canceled. Watches stay, and wait for entities that the new
        world may not have. Spawned entities are deleted and robots lose their state. A world without a robot that
        an actor of the run uses is refused.
        """


@runtime_checkable
class NamedPoses(Protocol):
    """A simulated world with named poses."""

    async def named_poses(self) -> Mapping[str, Pose3D]:
        """Return the named poses of the present world in `map`, in the order of its file."""


@runtime_checkable
class Snapshots(Protocol):
    """A simulated world whose complete state can be saved and restored during a run."""

    async def save_snapshot(self, name: str) -> None:
        """Save the state under a name, replacing an earlier state of that name."""

    async def restore_snapshot(self, name: str, seed: int | None) -> None:
        """Restore a state that was saved in this run.

        The time of the run goes on. Goals that were active then and are active now continue; others end as
        canceled. Robots resume their other motions of that time until they receive new commands. Watches stay.

        Args:
            name: Name of the state.
            seed: Seed for random numbers from there on; None to repeat those drawn then.
        """
