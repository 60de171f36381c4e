"""Parameters of a robot's navigation, by the names that they have in Nav2 where it has them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, NonNegativeFloat, PositiveFloat

from sim_nodes.files import Declared

PLUGIN = r"^[A-Za-z_][\w.-]*(:[A-Za-z_]\w*)?$"
"""Pattern of plugins: the name of an entry point, or `module:Class`."""

Parameter = bool | float | str
"""Value of a parameter of a plugin."""

Recovery = Literal["backup", "spin", "wait"]


class PluginDeclaration(Declared):
    """A planner or controller, and its own parameters."""

    plugin: str = Field(pattern=PLUGIN, max_length=200)
    parameters: dict[str, Parameter] = Field(default={}, max_length=64)

    def __hash__(self) -> int:
        return hash((self.plugin, frozenset(self.parameters.items())))


class NavigationDeclaration(Declared):
    """Parameters of the navigation of a base."""

    planner: PluginDeclaration | None = None  # by the drive and the outline
    controller: PluginDeclaration | None = None  # by the drive and the outline
    controller_frequency: float = Field(10.0, ge=1.0, le=50.0)  # decisions [Hz], rounded to ticks of 20 ms
    expected_planner_frequency: float = Field(1.0, ge=0.1, le=10.0)  # maximum rate of plans [Hz]
    xy_goal_tolerance: PositiveFloat = 0.01  # of the localised position [m]
    yaw_goal_tolerance: PositiveFloat = 0.1  # [rad]
    passed_goal_radius: PositiveFloat = 0.3  # [m] around poses that the robot drives through
    inflation_radius: NonNegativeFloat = 0.6  # [m] from obstacles within which floor costs more
    cost_scaling_factor: NonNegativeFloat = 30.0  # decrease of that cost with distance [1/m]
    inflation_cost: NonNegativeFloat = 6.0  # at the clearance, relative to free floor
    desired_linear_vel: PositiveFloat | None = None  # [m/s]; the maximum of the drive by default
    rotate_to_heading_angular_vel: PositiveFloat = 1.5  # [rad/s], and maximum in curves
    rotate_to_heading_min_angle: PositiveFloat = 0.785  # [rad] to the path from which the robot turns in place
    lookahead_dist: PositiveFloat = 0.4  # [m] along the path
    min_approach_linear_velocity: PositiveFloat = 0.03  # at the goal [m/s]
    required_movement_radius: PositiveFloat = 0.3  # [m] of progress within ...
    movement_time_allowance: PositiveFloat = 10.0  # ... this time [s]
    number_of_retries: int = Field(6, ge=0, le=100)  # recoveries without progress, before abort
    recoveries: tuple[Recovery, ...] = Field(("backup", "spin", "wait"), max_length=16)  # in turn
    backup_dist: PositiveFloat = 0.15  # [m]
    backup_speed: PositiveFloat = 0.1  # [m/s]
    spin_dist: PositiveFloat = 1.57  # [rad]
    wait_duration: PositiveFloat = 5.0  # [s]
    max_slope: float = Field(0.1, ge=0.0, le=1.0)  # of terrain [rad]; steeper terrain is an obstacle
    max_step: NonNegativeFloat | None = None  # [m]; a third of the radius of a wheel by default
