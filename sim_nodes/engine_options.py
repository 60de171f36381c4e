"""Optional parts of the contract of an engine; see `physics.py`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from sim_nodes.bodies import BodyModel, BodyState
from sim_nodes.geometry import (
    Array,
)


@runtime_checkable
class ManyBodies(Protocol):
    """Optional: adds and removes many bodies at a lower cost than one by one."""

    def add_bodies(self, bodies: Sequence[tuple[str, BodyModel, BodyState]]) -> None:
        """Add bodies; each as by `Engine.add_body`."""

    def remove_bodies(self, names: Sequence[str]) -> None:
        """Remove added bodies."""


@runtime_checkable
class DrivesBodies(Protocol):
    """Optional: moves the bodies whose models are `driven`, such as people.

    Arrays have a row for each driven body, in the order in which they were added.
    """

    def driven_poses(self) -> Array:
        """Return the poses of the driven bodies: x, y [m] and yaw [rad], shape (n, 3)."""

    def drive_bodies(self, velocities: Array, heights: Array) -> None:
        """Set the velocities of the driven bodies for the next tick; collisions may change them.

        Speeds increase by at most 20 m/s^2. Without a call in each tick, the bodies fall, except built-in ones.

        Args:
            velocities: x, y [m/s] in `map`, and yaw rate [rad/s], shape (n, 3), n >= 1.
            heights: Heights of the origins at the next tick [m], shape (n,).
        """


@runtime_checkable
class MeasuresWork(Protocol):
    """Optional: knows the mechanical work of the motors of robots."""

    def motor_work(self, robot: str) -> float:
        """Return the work that the motors of a robot have delivered since the scene was built or reset [J].

        It is the sum over steps, and over motors that drive their joint, of force times mean speed times duration.
        Motors that brake count as 0. It may lack the last step. Saved states include it.
        """

    def measure_work(self, robot: str) -> None:
        """Measure the work of a robot in each step from now on; before, the engine may sample it at 50 Hz."""


@runtime_checkable
class SavesState(Protocol):
    """Optional: saves and restores states."""

    def save(self) -> Mapping[str, Any]:
        """Return all that later states depend on, except the scene, as values that `sim_nodes.codec` accepts.

        Raises:
            UnsavableState: The state is too large.
        """

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Continue from a saved state, bit-identically, also in another process.

        Replaces all bodies that were added and all states that were set since the scene was built.

        Args:
            saved: Result of `save` in an engine of the same version with the same scene.

        Raises:
            UnsavableState: The state belongs to another scene or version.
        """


@runtime_checkable
class Rewinds(Protocol):
    """Optional: goes back a little, at a small part of the cost of going ahead.

    Nodes of such engines simulate ahead of grants when the client announces more.
    """

    def checkpoint(self) -> Any:
        """Return what later states depend on, except the scene and its bodies; later steps do not change it.

        Returns:
            None if it is impossible to go back to this state. Going back to older checkpoints than the last may be
            slow.
        """

    def rewind(self, checkpoint: Any) -> None:
        """Continue from a checkpoint, bit-identically.

        Since then, no body was added, removed or moved by `set_body_state`.
        """
