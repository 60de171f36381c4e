"""Frames and their poses in `map`: those of robots, by truth and by localisation, and bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from sim_nodes.entities import Entities
from sim_nodes.geometry import Pose2
from sim_nodes.outcomes import unknown
from sim_nodes.physics import Engine
from sim_nodes.robots.robot import Robot


class Frames:
    """The frames of a world. Frames without the name of a robot belong to the first wheeled robot.

    Args:
        engine: Engine with the poses of robots and bodies.
        robots: Robots by name.
        entities: Entities, whose bodies are frames.
    """

    def __init__(self, engine: Engine, robots: Mapping[str, Robot], entities: Entities) -> None:
        self._engine = engine
        self._entities = entities
        self._first = next((robot.name for robot in robots.values() if robot.drives), None)
        self._poses = dict(self._poses_of(robots))

    def _poses_of(self, robots: Mapping[str, Robot]) -> Iterator[tuple[str, Callable[[], Pose2 | None]]]:
        yield "map", lambda: Pose2(0.0, 0.0, 0.0)
        for robot in robots.values():
            yield robot.truth_frame, partial(self.true_pose, robot.name)
            if robot.drives:
                for prefix in ("", f"{robot.name}/") if robot.name == self._first else (f"{robot.name}/",):
                    yield f"{prefix}base_link", robot.mobile.localised_pose
                    yield f"{prefix}odom", robot.mobile.localisation.map_to_odom

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all frames except bodies."""
        return tuple(self._poses)

    def of(self, robot: Robot) -> tuple[str, ...]:
        """Return a robot's frames: `map`, its own, and, of the first wheeled robot, the unprefixed ones."""
        common = ("map", "odom", "base_link") if robot.name == self._first else ("map",)
        own = (f"{robot.name}/odom", f"{robot.name}/base_link") if robot.drives else ()
        return (*common, *own, robot.truth_frame)

    def pose(self, frame: str) -> Pose2 | None:
        """Return the pose of a frame or body in `map`; None if it is unknown yet."""
        if frame in self._poses:
            return self._poses[frame]()
        return self.true_pose(frame) if frame in self._entities.bodies else None

    def true_pose(self, name: str) -> Pose2:
        """Return the true pose of a robot or body."""
        return self._engine.body_state(name).planar

    def own(self, name: str, robot: str) -> str:
        """Resolve a frame name for a robot: its own frame, if each robot has one of that name.

        Raises:
            RequestRefused: The frame is unknown.
        """
        own = f"{robot}/{name}"
        if own in self._poses:
            return own
        self.check(name)
        return name

    def check(self, name: str) -> None:
        """Refuse unknown frames."""
        known = [*self._poses, *self._entities.bodies]
        if name not in known:
            raise unknown(f"frame {name!r}", "frames", known)
