"""Requests to spawn the bodies of a file, and the spawned bodies."""

from __future__ import annotations

from collections.abc import Collection

from seoro.deferred import dataclass
from sim_nodes.geometry import compose_frames, inverse_frame
from sim_nodes.models.scenes import SceneBody
from sim_nodes.physics import BodyModel, BodyState

LONGEST = 64  # [characters] of a name
NUMBERED = 58  # [characters] of a name that gets a number


@dataclass(frozen=True)
class Spawned:
    """A spawned body; `scene` is the first body of its file, empty for that itself."""

    model: BodyModel
    time: float  # [s]
    tags: tuple[str, ...] = ()
    scene: str = ""


@dataclass(frozen=True)
class SpawnRequest:
    """The bodies of a file to spawn.

    Attributes:
        name: Name of the first body.
        bodies: The bodies; see `placed_bodies`.
        state: State of the first body.
        rename: Whether the first body may have another name if its own is in use.
        tags: Tags of all bodies.
    """

    name: str
    bodies: tuple[SceneBody, ...]
    state: BodyState
    rename: bool
    tags: tuple[str, ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Parts of the file without effect."""
        return tuple(dict.fromkeys(note for body in self.bodies for note in body.model.notes))


def placed_bodies(
    name: str, bodies: tuple[SceneBody, ...], state: BodyState, taken: Collection[str]
) -> dict[str, tuple[BodyModel, BodyState]]:
    """Return the bodies of a file by name, with their states in `map`.

    Args:
        name: Name of the first body; others are named `NAME_OTHER`.
        bodies: The bodies, with states in one frame.
        state: State of the first body; the others keep their poses relative to it, and are at rest.
        taken: Names in use.
    """
    first, *others = bodies
    found = {name: (first.model, state)}
    origin = compose_frames(state.frame, inverse_frame(first.state.frame))
    for other in others:
        own = first_free(f"{name}_{other.name}"[:LONGEST], {*taken, *found})
        place, turn = compose_frames(origin, other.state.frame)
        found[own] = (other.model, BodyState(place, turn))
    return found


def first_free(name: str, taken: Collection[str]) -> str:
    """Return a name, or the first one with a number that is not taken."""
    if name not in taken:
        return name
    numbered = (f"{name[:NUMBERED]}_{number}" for number in range(1, len(taken) + 2))
    return next(new for new in numbered if new not in taken)
