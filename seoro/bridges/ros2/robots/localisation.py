"""Localisation of a robot, as by AMCL: set the pose, restart, and wait for a pose."""

from __future__ import annotations

import math
import time
from typing import Any

import anyio
import numpy as np

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.lazy_publisher import LazyPublisher
from seoro.bridges.ros2.robots.link import DISCOVERY_TIMEOUT, RobotLink
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.wire import LATCHED
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused

POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE_TIMEOUT = 10.0  # [s] from an initial pose to a pose of the localisation
RETRY = 1.0  # [s] between initial poses: the first may arrive before the localisation is ready
VARIANCES = {0: 0.25, 7: 0.25, 35: 0.0685}  # of x, y [m^2] and yaw [rad^2]: 0.5 m and 15 degrees, as RViz sends
BASE = "base_link"
PLANAR = (0, 1, 5)  # rows of x, y and yaw in a covariance


class Localisation:
    """Localisation of a robot.

    Args:
        link: Link to the robot.
        base: Names of the topics and services of its base.
    """

    def __init__(self, link: RobotLink, base: Base) -> None:
        self._link = link
        self._base = base
        self._latest: Message | None = None
        self._updated = 0.0  # arrival of the latest pose, by the machine's clock [s]
        self._initial_poses = LazyPublisher(link, base.initial_pose, lambda _: POSE)

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs."""
        return {
            wire.SET_INITIAL_POSE: self._set_initial_pose,
            wire.REINITIALIZE_GLOBAL_LOCALIZATION: self._restart,
            wire.WATCH_LOCALIZATION: self._watch,
        }

    @property
    def position(self) -> tuple[float, float] | None:
        """Estimated position [m]; None before the first estimate."""
        if self._latest is None:
            return None
        position = self._latest.pose.pose.position
        return position.x, position.y

    @property
    def deviation(self) -> float | None:
        """Standard deviation of the estimated position [m]; None while it is unknown.

        A negative variance counts as unknown, as some localisations use it.
        """
        if self._latest is None:
            return None
        variances = [float(self._latest.pose.covariance[index]) for index in (0, 7)]  # of x and y
        return None if min(variances) < 0.0 else math.sqrt(sum(variances) / 2.0)

    async def open(self) -> None:
        """Subscribe to the pose, and prepare to publish the initial pose."""
        await self._link.listen(self._base.pose, POSE, self._on_pose, LATCHED, self._forget)
        self._link.tasks.start_soon(self._initial_poses.run)

    def _forget(self) -> None:
        """Forget the estimate: its publisher has disappeared, or restarts."""
        self._latest = None

    def _on_pose(self, message: Message) -> None:
        """Set the estimate.

        Raises:
            ValueError: The pose is invalid; the earlier one is forgotten.
        """
        self._forget()
        numbers = [*message.pose.pose.position, *message.pose.pose.orientation, *message.pose.covariance]
        if not np.isfinite(numbers).all():
            topic = self._link.node.resolve(self._base.pose)
            raise ValueError(f"invalid pose on {topic}: the pose or its covariance is not finite")
        self._latest, self._updated = message, time.monotonic()

    async def _set_initial_pose(self, request: wire.SetInitialPose) -> None:
        outlet, graph = self._initial_poses, self._link.node.graph
        with anyio.move_on_after(DISCOVERY_TIMEOUT):
            publication = await outlet.wait()
            await graph.wait_for(lambda graph: graph.subscriptions(outlet.topic))
            await publication.wait_for_subscription()
        if outlet.publication is None or not graph.subscriptions(outlet.topic):
            silent = f"no subscription to {outlet.topic} on the robot: its localisation is not running"
            raise RequestRefused(Result.INCORRECT_STATE, outlet.problem or silent)
        message = self._initial_pose(request.pose)
        self._link.intake.read()
        start = time.monotonic()
        with anyio.move_on_after(POSE_TIMEOUT):
            while self._updated < start:
                outlet.publication.publish(message)
                with anyio.move_on_after(RETRY):
                    await self._link.intake.arrivals.wait_for(lambda: self._updated >= start)
        if self._updated < start:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"no pose of the localisation on {self._link.node.resolve(self._base.pose)} within "
                f"{POSE_TIMEOUT:g} s after the initial pose: {self._link.explain_silence(self._base.pose)}",
            )

    def _initial_pose(self, pose: wire.Pose3D) -> dict[str, Any]:
        covariance = np.zeros(36)
        covariance[list(VARIANCES)] = list(VARIANCES.values())
        return {
            # A stamp of zero selects the latest transform, since the clock of the robot may differ.
            "header": geometry.header(self._base.map_frame, 0.0),
            "pose": {"pose": geometry.pose_message(pose), "covariance": covariance},
        }

    async def _restart(self, _request: wire.RobotName) -> None:
        await self._link.call(self._base.global_localization, "std_srvs/srv/Empty", {})
        self._forget()

    async def _watch(self, request: wire.WatchLocalization) -> None:
        self._link.work.start(request.id, self._wait)

    async def _wait(self) -> str:
        await self._link.intake.arrivals.wait_for(lambda: self._latest is not None)
        return ""

    def estimate(self) -> wire.Localization:
        """Return the present estimate."""
        latest = self._latest
        if latest is None:
            return wire.Localization(pose=None, covariance=None, particles=0, error=None)
        covariance = np.asarray(latest.pose.covariance).reshape(6, 6)[np.ix_(PLANAR, PLANAR)]
        # The localisation publishes a pose after some motion only; transforms have the present one.
        present = self._link.frames.pose(BASE, self._base.map_frame)
        return wire.Localization(
            pose=present or geometry.pose(latest.pose.pose),
            covariance=tuple(covariance.ravel().tolist()),
            particles=0,  # unknown
            error=None,  # unknown
        )
