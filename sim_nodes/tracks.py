"""Tracks for the trace of a run: poses of robots and movable bodies, plans and scans, sampled while time passes.

Samples wait here until an answer to a grant takes them. They do not affect the simulation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from struct import Struct

from seoro.bridges import wire
from seoro.deferred import dataclass
from seoro.robotics.tracks import MAX_POSE_RATE
from sim_nodes.entities import Entities
from sim_nodes.outcomes import operation_failed
from sim_nodes.physics import Engine
from sim_nodes.plans import Plans
from sim_nodes.robots.moving_links import moving_links
from sim_nodes.robots.robot import Robot
from sim_nodes.scan_samples import ScanSamples
from sim_nodes.scenery import describe_body, link_values
from sim_nodes.ticks import IDLE_TICKS, TICK
from sim_nodes.worlds.loader import World

SCALE = 10_000  # values are rounded to 1 / SCALE
MAX_WAITING = 16 * 1024 * 1024  # [bytes] of samples that wait for a grant
OVERHEAD = 200  # [bytes] of a sample besides its numbers

POSE = Struct(f"<{wire.POSE_VALUES}d")
LINK = Struct(f"<{wire.LINK_VALUES}d")
BELIEVED = Struct(f"<{wire.BELIEVED_VALUES}d")


@dataclass(frozen=True)
class Mark:
    """State of the tracks, to return to."""

    poses: Mapping[str, bytes]
    links: Mapping[tuple[str, str], bytes]
    believed: Mapping[str, bytes]
    since: Mapping[str, float]
    plans: Plans
    scans: ScanSamples
    waiting: int  # number of samples
    size: int  # [bytes] of them


class Tracks:
    """Samples of poses.

    Attributes:
        every: Period in ticks; 0 while nothing is sampled.
    """

    def __init__(self) -> None:
        self.every = 0
        self._poses: dict[str, bytes] = {}  # last samples by entity
        self._links: dict[tuple[str, str], bytes] = {}  # by robot and link
        self._believed: dict[str, bytes] = {}
        self._since: dict[str, float] = {}  # times at which the described entities were spawned [s]
        self._plans = Plans()
        self._scans = ScanSamples()
        self._world: World | None = None
        self._scene: wire.Scene | None = None  # for the next sample
        self._waiting: list[wire.TrackSample] = []
        self._size = 0  # [bytes] of the waiting samples, about
        self._dropped = 0

    def start(
        self, rate: float, scans: float, world: World, robots: Mapping[str, Robot], entities: Entities
    ) -> None:
        """Start to sample. The client knows the scene of this time.

        Args:
            rate: Samples per second; 0 stops it.
            scans: Scans of each lidar per second, at most `rate`; 0 for none.
            world: The world.
            robots: Robots by name.
            entities: Entities of the world.

        Raises:
            RequestRefused: A rate is invalid.
        """
        if not 0.0 <= rate <= MAX_POSE_RATE:
            raise operation_failed(f"invalid rate {rate} of tracks; expected 0 to {MAX_POSE_RATE:g} Hz")
        if not 0.0 <= scans <= rate:
            raise operation_failed(f"invalid rate {scans} of scans: expected 0 to {rate:g} Hz, the rate of tracks")
        self.stop()
        self._scans = ScanSamples(scans)
        self._world, self._since = world, _times_of(robots, entities)
        self.every = 0 if rate == 0.0 else max(1, round(1.0 / (rate * TICK)))

    def stop(self) -> None:
        """Stop, and drop the waiting samples."""
        self.every = 0
        self.discard()
        self._poses, self._links, self._believed, self._scene = {}, {}, {}, None
        self._plans, self._scans = Plans(), ScanSamples()

    def continue_in(self, world: World, describe: Callable[[], wire.Scene]) -> None:
        """Include all entities in the next sample, and the scene if the world is another one.

        Args:
            world: The present world.
            describe: Returns its scene.
        """
        self._poses, self._links, self._believed = {}, {}, {}
        if self.every and world != self._world:
            self._world, self._scene = world, describe()

    def ticks_to_next(self, tick: int) -> int:
        """Return the number of ticks to the next sample, or to the update of idle robots before it."""
        idle = IDLE_TICKS - tick % IDLE_TICKS
        return min(idle, self.every - tick % self.every) if self.every else idle

    def is_due(self, tick: int) -> bool:
        """Whether a tick is sampled."""
        return self.every > 0 and tick % self.every == 0

    def sample(
        self, time: float, tick: int, engine: Engine, robots: Mapping[str, Robot], entities: Entities
    ) -> None:
        """Sample the poses, unless tracks are stopped.

        Args:
            time: Present time [s].
            tick: Present tick.
            engine: Engine with the true states.
            robots: Robots by name.
            entities: Entities of the world.
        """
        if not self.every:
            return
        since = _times_of(robots, entities)
        poses = {name: _pose(engine, name) for name in since}
        believed = dict(_believed(robots))
        moved = {name: pose for name, pose in poses.items() if self._poses.get(name) != pose}
        localised = {name: pose for name, pose in believed.items() if self._believed.get(name) != pose}
        removed = tuple(name for name in self._since if name not in since)
        new = [name for name, start in since.items() if self._since.get(name) != start]
        scene, self._scene = self._scene, None
        self._poses, self._believed, self._since = poses, believed, since
        plans = tuple(self._plans.sample(time, robots))
        scans = tuple(self._scans.sample(time, tick, robots))
        moved_links = tuple(self._sample_links(engine, robots))
        if moved or localised or removed or plans or scans or moved_links:
            self._add(
                wire.TrackSample(
                    time=time,
                    entities=tuple(moved),
                    poses=b"".join(moved.values()),
                    localised=tuple(localised),
                    believed=b"".join(localised.values()),
                    removed=removed,
                    added=() if scene is not None else tuple(describe_body(entities, name) for name in new),
                    scene=scene,
                    plans=plans,
                    scans=scans,
                    moved_links=moved_links,
                )
            )

    def _sample_links(self, engine: Engine, robots: Mapping[str, Robot]) -> Iterator[wire.TrackLinks]:
        """Yield the links that moved against the base of their robot, of each robot with such links."""
        for name, robot in robots.items():
            links = moving_links(robot.declaration)
            base = engine.body_state(name) if links else None
            moved: dict[str, bytes] = {}
            for link in links:
                assert base is not None, "of a robot with links"
                pose = LINK.pack(*link_values(engine, name, link, base))
                if self._links.get((name, link)) != pose:
                    self._links[name, link] = moved[link] = pose
            if moved:
                yield wire.TrackLinks(robot=name, links=tuple(moved), poses=b"".join(moved.values()))

    def _add(self, sample: wire.TrackSample) -> None:
        size = OVERHEAD + len(sample.poses) + len(sample.believed)
        size += sum(len(plan.points) for plan in sample.plans) + sum(len(scan.ranges) for scan in sample.scans)
        size += sum(len(moved.poses) for moved in sample.moved_links)
        if self._size + size > MAX_WAITING:
            self._dropped += 1
            return
        self._waiting.append(sample)
        self._size += size

    def take(self) -> tuple[tuple[wire.TrackSample, ...], int]:
        """Return the waiting samples, and the number of dropped ones."""
        samples, dropped = tuple(self._waiting), self._dropped
        self.discard()
        return samples, dropped

    def discard(self) -> None:
        """Drop the waiting samples."""
        self._waiting, self._size, self._dropped = [], 0, 0

    def mark(self) -> Mark:
        """Return the state, before the simulation goes ahead."""
        state = self._poses, dict(self._links), self._believed, self._since, self._plans.copy(), self._scans.copy()
        return Mark(*state, len(self._waiting), self._size)

    def rewind(self, mark: Mark) -> None:
        """Return to a state."""
        self._poses, self._links = dict(mark.poses), dict(mark.links)
        self._believed, self._since = dict(mark.believed), dict(mark.since)
        self._plans, self._scans = mark.plans.copy(), mark.scans.copy()
        del self._waiting[mark.waiting :]
        self._size = mark.size


def _times_of(robots: Mapping[str, Robot], entities: Entities) -> dict[str, float]:
    """Return the sampled entities, with the times at which they were spawned [s]."""
    return dict.fromkeys(robots, 0.0) | entities.movable()


def _pose(engine: Engine, name: str) -> bytes:
    state = engine.body_state(name)
    w, x, y, z = state.orientation
    values = (*state.position, x, y, z, w, *state.linear, *state.angular)
    return POSE.pack(*[round(value * SCALE) / SCALE for value in values])


def _believed(robots: Mapping[str, Robot]) -> Iterator[tuple[str, bytes]]:
    for robot in robots.values():
        pose = robot.mobile.localised_pose() if robot.drives else None
        if pose is not None:
            values = (pose.x, pose.y, pose.yaw)
            yield robot.name, BELIEVED.pack(*[round(value * SCALE) / SCALE for value in values])
