"""Verbs that drive robots by velocities."""

from __future__ import annotations

from seoro.bridges import wire
from seoro.bridges.wire import Empty, Result
from seoro.bridges.wire.refusal import RequestRefused, check_drive_duration, check_finite, check_id
from sim_nodes.robots.diff_drive import Velocity
from sim_nodes.simulator import Simulator
from sim_nodes.verbs.handling import Handling


def _drive(simulator: Simulator, request: wire.Drive) -> Empty:
    check_id(request.id)
    velocity = Velocity(request.linear, request.angular)
    check_finite("velocity", *velocity)
    check_drive_duration(request.duration)
    simulator.simulation.drive(request.robot, request.id, velocity, request.duration)
    return Empty()


def _cmd_vel(simulator: Simulator, request: wire.CmdVel) -> Empty:
    linear, angular = request.twist.linear, request.twist.angular
    check_finite("twist", linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    if any((linear.y, linear.z, angular.x, angular.y)):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            "a robot with two wheels drives along its x axis and turns about z: leave the rest of the twist at 0",
        )
    simulator.simulation.command_velocity(request.robot, Velocity(linear.x, angular.z))
    return Empty()


HANDLERS: tuple[Handling, ...] = ((wire.DRIVE, _drive), (wire.CMD_VEL, _cmd_vel))
