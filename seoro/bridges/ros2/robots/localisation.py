"""Where a robot believes to be: told, found anew, and waited for, as AMCL does it."""

from __future__ import annotations

import math
import time
from typing import Any

import anyio
import numpy as np

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.robots.link import FOUND_WITHIN, Link
from seoro.bridges.ros2.robots.outlet import Outlet
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.wire import Durability, Qos
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.changes import Changes

POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
LATCHED = Qos(durability=Durability.TRANSIENT_LOCAL, depth=1)
TAKEN_WITHIN = 10.0  # [s] from an initial pose to a pose of the localisation
PUBLISHED_EVERY = (
    1.0  # [s] until an initial pose is told again: the first may come before the localisation is ready
)
VARIANCES = {0: 0.25, 7: 0.25, 35: 0.0685}  # of x, y [m^2] and yaw [rad^2]: 0.5 m and 15 degrees, as RViz sends
PLANAR = (0, 1, 5)  # rows of x, y and yaw in a covariance


class Localisation:
    """The localisation of a robot.

    Args:
        link: To the robot.
        base: What it calls things.
        work: Where watches run.
    """

    def __init__(self, link: Link, base: Base, work: Work) -> None:
        self._link = link
        self._base = base
        self._work = work
        self._latest: Message | None = None
        self._since = 0.0  # by the machine's clock [s]
        self._changes = Changes()
        self._initial_poses = Outlet(link, base.initial_pose, lambda _: POSE)

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves."""
        return {
            wire.SET_INITIAL_POSE: self._set_initial_pose,
            wire.REINITIALIZE_GLOBAL_LOCALIZATION: self._start_over,
            wire.WATCH_LOCALIZATION: self._watch,
            wire.GET_LOCALIZATION: self._get,
        }

    @property
    def position(self) -> tuple[float, float] | None:
        """Where it last said the robot to be [m]; None while it has not."""
        if self._latest is None:
            return None
        place = self._latest.pose.pose.position
        return place.x, place.y

    @property
    def deviation(self) -> float | None:
        """Standard deviation of the position that it states [m]; None while it has stated none.

        Variances below 0 state none: some say by them that they do not know.
        """
        if self._latest is None:
            return None
        variances = [float(self._latest.pose.covariance[index]) for index in (0, 7)]  # of x and y
        return None if min(variances) < 0.0 else math.sqrt(sum(variances) / 2.0)

    async def open(self) -> None:
        """Listen to what it says, and be ready to tell it where the robot is."""
        await self._link.listen(self._base.pose, POSE, self._take, LATCHED)
        self._link.tasks.start_soon(self._link.watch_end, self._base.pose, self._forget)
        self._link.tasks.start_soon(self._initial_poses.run)

    def _forget(self) -> None:
        """Forget where it believed to be: it is gone, or begins anew."""
        self._latest = None

    def _take(self, message: Message) -> None:
        """Take where it believes to be.

        Raises:
            ValueError: It says no place, and what it said before is forgotten.
        """
        self._forget()
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        numbers = [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w, *message.pose.covariance]
        if not np.isfinite(numbers).all():
            topic = self._link.node.resolve(self._base.pose)
            raise ValueError(
                f"a pose on {topic} is none: it, or its covariance, has a part that is no finite number"
            )
        self._latest, self._since = message, time.monotonic()
        self._changes.tell()

    async def _set_initial_pose(self, request: wire.SetInitialPose) -> wire.Empty:
        outlet, graph = self._initial_poses, self._link.node.graph
        with anyio.move_on_after(FOUND_WITHIN):
            publication = await outlet.wait()
            await graph.wait_for(lambda graph: graph.subscriptions(outlet.topic))
            await publication.wait_for_subscription()
        if outlet.publication is None or not graph.subscriptions(outlet.topic):
            silent = f"nobody on the robot subscribes to {outlet.topic}: its localisation does not run"
            raise RequestRefused(Result.INCORRECT_STATE, outlet.problem or silent)
        message = self._initial_pose(request.pose)
        began = time.monotonic()
        with anyio.move_on_after(TAKEN_WITHIN):
            while self._since < began:
                outlet.publication.publish(message)
                with anyio.move_on_after(PUBLISHED_EVERY):
                    await self._changes.wait_for(lambda: self._since >= began)
        if self._since < began:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the localisation has said nothing on {self._link.node.resolve(self._base.pose)} for "
                f"{TAKEN_WITHIN:g} s after it was told where the robot is: "
                f"{self._link.why_silent(self._base.pose)}",
            )
        return wire.Empty()

    def _initial_pose(self, pose: wire.Pose) -> dict[str, Any]:
        covariance = np.zeros(36)
        covariance[list(VARIANCES)] = list(VARIANCES.values())
        return {
            # A stamp of zero means the latest transform, whatever the clock of the robot shows.
            "header": geometry.header(self._base.map_frame, 0.0),
            "pose": {"pose": geometry.pose_message(pose), "covariance": covariance},
        }

    async def _start_over(self, _request: wire.LocalisedRobot) -> wire.Empty:
        await self._link.call(self._base.global_localization, "std_srvs/srv/Empty", {})
        self._forget()
        return wire.Empty()

    async def _watch(self, request: wire.WatchLocalization) -> wire.Empty:
        self._work.start(request.id, self._wait)
        return wire.Empty()

    async def _wait(self) -> str:
        await self._changes.wait_for(lambda: self._latest is not None)
        return ""

    async def _get(self, _request: wire.LocalisedRobot) -> wire.Localization:
        latest = self._latest
        if latest is None:
            return wire.Localization(pose=None, covariance=None, particles=0, error=None)
        covariance = np.asarray(latest.pose.covariance).reshape(6, 6)[np.ix_(PLANAR, PLANAR)]
        return wire.Localization(
            pose=geometry.pose(latest.pose.pose),
            covariance=tuple(covariance.ravel().tolist()),
            particles=0,  # it does not tell
            error=None,  # nobody knows
        )
