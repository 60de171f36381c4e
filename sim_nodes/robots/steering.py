"""Driving by given velocities: for a while, or as commands come.

A goal holds its velocity for a number of ticks. A command holds until the next one, and for `COMMAND_TIMEOUT` at
most, as the Create 3 does it, so that a robot whose commander has died stands still. Wheels speed up and slow
down within the limits of the robot; at the end they are told to stand still at once.
"""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.goals import Ended
from sim_nodes.robots.declaration import DriveDeclaration
from sim_nodes.robots.diff_drive import AT_REST, Velocity
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

COMMAND_TIMEOUT = 0.5  # [s]


@dataclass(frozen=True)
class Order:
    """A velocity to drive with, through a tick; `goal` is the id to report its end by, None for a command."""

    velocity: Velocity
    last: int  # tick
    goal: str | None


class Steering(Stateful):
    """What a base has been told to drive, if anything.

    Args:
        drive: Its limits.
    """

    STATE = ("_velocity", "order")

    def __init__(self, drive: DriveDeclaration) -> None:
        self._drive = drive
        self._velocity = AT_REST
        self.order: Order | None = None

    @property
    def goal(self) -> str | None:
        """The id of the goal that it is driven for."""
        return self.order.goal if self.order is not None else None

    def check(self, robot: str, velocity: Velocity) -> None:
        """Refuse velocities that the robot cannot have."""
        linear, angular = self._drive.max_speed, self._drive.max_turn_rate
        if abs(velocity.linear) > linear or abs(velocity.angular) > angular:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{robot} drives with up to {linear:g} m/s and turns with up to {angular:g} rad/s, "
                f"not with {velocity.linear:g} m/s and {velocity.angular:g} rad/s",
            )

    def follow(self, order: Order) -> None:
        """Take up an order, from the velocity that there is."""
        self.order = order

    def drop(self) -> None:
        """Forget the order; the wheels have to be stopped by whoever calls."""
        self.order, self._velocity = None, AT_REST

    def control(self, tick: int) -> tuple[Velocity, Ended | None]:
        """The velocity from this tick on, and the end of the goal if it ends. Only with an order."""
        order = self.order
        assert order is not None
        if tick >= order.last:
            self.drop()
            return AT_REST, Ended(order.goal, Outcome.SUCCEEDED) if order.goal is not None else None
        drive = self._drive
        self._velocity = Velocity(
            _towards(self._velocity.linear, order.velocity.linear, drive.max_acceleration * TICK),
            _towards(self._velocity.angular, order.velocity.angular, drive.max_turn_acceleration * TICK),
        )
        return self._velocity, None


def _towards(present: float, wanted: float, by: float) -> float:
    """The value that is nearest to a wanted one, and no more than `by` from the present."""
    return min(max(wanted, present - by), present + by)
