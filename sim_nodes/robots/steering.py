"""Driving with given velocities: for a duration, or by a stream of commands.

A goal holds its velocity for a number of ticks. A command holds until the next one, and for `COMMAND_TIMEOUT` at
most, as on the Create 3, so that a robot stops when its commander dies. Wheels accelerate within the limits of the
robot; at the end they stop at once.
"""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.wire import Outcome
from sim_nodes.goals import GoalResult
from sim_nodes.refusals import operation_failed
from sim_nodes.robots.declaration import DriveDeclaration
from sim_nodes.robots.diff_drive import AT_REST, Velocity
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

COMMAND_TIMEOUT = 0.5  # [s]


@dataclass(frozen=True)
class VelocityCommand:
    """A velocity to drive with until a tick; `goal` is the id of the goal, None for a command."""

    velocity: Velocity
    last: int  # tick
    goal: str | None


class Steering(Stateful):
    """The velocity command of a base, if any.

    Args:
        drive: Declaration with the limits.
    """

    STATE = ("_velocity", "command")

    def __init__(self, drive: DriveDeclaration) -> None:
        self._drive = drive
        self._velocity = AT_REST
        self.command: VelocityCommand | None = None

    @property
    def goal(self) -> str | None:
        """Id of the active goal."""
        return self.command.goal if self.command is not None else None

    def check(self, robot: str, velocity: Velocity) -> None:
        """Refuse velocities beyond the limits of the robot."""
        linear, angular = self._drive.max_speed, self._drive.max_turn_rate
        if abs(velocity.linear) > linear or abs(velocity.angular) > angular:
            raise operation_failed(
                f"invalid velocity for {robot}; expected up to {linear:g} m/s and {angular:g} rad/s, "
                f"found {velocity.linear:g} m/s and {velocity.angular:g} rad/s"
            )

    def follow(self, command: VelocityCommand) -> None:
        """Start a command, from the present velocity."""
        self.command = command

    def clear(self) -> None:
        """Drop the command; the caller must stop the wheels."""
        self.command, self._velocity = None, AT_REST

    def control(self, tick: int) -> tuple[Velocity, GoalResult | None]:
        """Return the velocity from this tick on, and the result of the goal if it ends; requires a command."""
        command = self.command
        assert command is not None
        if tick >= command.last:
            self.clear()
            return AT_REST, GoalResult(command.goal, Outcome.SUCCEEDED) if command.goal is not None else None
        drive = self._drive
        self._velocity = Velocity(
            _towards(self._velocity.linear, command.velocity.linear, drive.max_acceleration * TICK),
            _towards(self._velocity.angular, command.velocity.angular, drive.max_turn_acceleration * TICK),
        )
        return self._velocity, None


def _towards(present: float, wanted: float, by: float) -> float:
    """Return the value nearest to `wanted` that differs from `present` by at most `by`."""
    return min(max(wanted, present - by), present + by)
