"""Frames by name, and where they are in the map: of robots, truly and as they believe, and of bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.entities import Entities
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Engine
from sim_nodes.robots.robot import Robot


class Frames:
    """The frames of a world; those without a robot's name are the first robot's that drives.

    Args:
        engine: Knows where robots and bodies are.
        robots: By name.
        entities: Bodies are frames by their names.
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
                    yield f"{prefix}odom", robot.mobile.map_to_odom

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all frames but bodies."""
        return tuple(self._poses)

    def of(self, robot: Robot) -> tuple[str, ...]:
        """Names of the frames of a robot: `map`, its own, and those without a name for the first that drives."""
        common = ("map", "odom", "base_link") if robot.name == self._first else ("map",)
        own = (f"{robot.name}/odom", f"{robot.name}/base_link") if robot.drives else ()
        return (*common, *own, robot.truth_frame)

    def pose(self, frame: str) -> Pose2 | None:
        """The pose of a frame or a body in the map; None when it has none."""
        if frame in self._poses:
            return self._poses[frame]()
        return self.true_pose(frame) if frame in self._entities.bodies else None

    def true_pose(self, name: str) -> Pose2:
        """Where a robot or a body really is."""
        return self._engine.body_state(name).planar

    def own(self, name: str, robot: str) -> str:
        """The frame that a robot means by a name: its own, if each robot has such a frame.

        Raises:
            RequestRefused: There is none.
        """
        own = f"{robot}/{name}"
        if own in self._poses:
            return own
        self.check(name)
        return name

    def check(self, name: str) -> None:
        """Refuse what names neither a frame nor a body."""
        known = [*self._poses, *self._entities.bodies]
        if name not in known:
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no frame or body {name!r}: known are {listed(known)}"
            )
