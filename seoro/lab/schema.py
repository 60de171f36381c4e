"""The form of a lab file.

simulators:
  hall: {simulator: mujoco, world: hall}      # started for the run; or {connect: tcp/127.0.0.1:7450}
bridges:
  floor: {connect: tcp/127.0.0.1:7460}        # a bridge to robots that is running
robots:                                       # of each actor, where it lives and what it is called there
  leader: {in: floor, as: turtlebot4}
  follower: {in: hall, as: second}
  tb1:                                        # one with a type is for whoever wants such a robot
    in: floor
    type: turtlebot4
    can: [navigate, carry]
    limits: {speed: 0.3, area: {x: [0, 5], y: [-2, 2]}}
    before: {battery: 0.3, localised: true, area: {x: [0, 1], y: [0, 1]}}
    after: {home: {x: 0.5, y: 0.5}}           # or {scenario: reset.osc}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]
NodeName = Annotated[str, Field(pattern=r"^[a-z0-9_-]+$")]
Text = Annotated[str, Field(min_length=1, max_length=1000)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SimulatorFile(_Part):
    """A simulator: to start by its name, or to connect to.

    Args:
        simulator: Its name, such as `mujoco`.
        connect: Zenoh endpoint of one that runs, or of the router that it is connected to.
        name: Of the one that runs, where there are several nodes at one router.
        world: Name of its world, or path of a world file from the folder of the lab file.
    """

    simulator: Text | None = None
    connect: Text | None = None
    name: NodeName | None = None
    world: Text | None = None

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.simulator is None) == (self.connect is None):
            raise ValueError("say either which `simulator` to start, or where to `connect` to one")
        if self.name is not None and self.connect is None:
            raise ValueError("a `name` tells apart simulators to `connect` to: leave it out")
        return self


class BridgeFile(_Part):
    """A bridge to robots that is running.

    Args:
        connect: Zenoh endpoint of the bridge, or of the router that it is connected to.
        name: Of the bridge, where there are several at one router.
    """

    connect: Text
    name: NodeName | None = None


Number = Annotated[float, Field(allow_inf_nan=False)]
Word = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]


class AreaFile(_Part):
    """A rectangle in the map: from and to [m]."""

    x: tuple[Number, Number]
    y: tuple[Number, Number]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.x[0] >= self.x[1] or self.y[0] >= self.y[1]:
            raise ValueError("an area is `{x: [FROM, TO], y: [FROM, TO]}`, with FROM before TO")
        return self

    def has(self, x: float, y: float) -> bool:
        """Whether a place [m] is in it."""
        return self.x[0] <= x <= self.x[1] and self.y[0] <= y <= self.y[1]

    def __str__(self) -> str:
        return f"x from {self.x[0]:g} to {self.x[1]:g} m, y from {self.y[0]:g} to {self.y[1]:g} m"


class LimitsFile(_Part):
    """What a run may ask of a robot at most.

    Args:
        speed: Of commands of velocity [m/s].
        area: In which goals have to lie.
    """

    speed: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None
    area: AreaFile | None = None


class BeforeFile(_Part):
    """What has to be so before a run.

    Args:
        battery: Charge, from 0 to 1.
        localised: Whether the robot has to know where it is.
        area: Where it has to be.
    """

    battery: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    localised: Literal[True] | None = None
    area: AreaFile | None = None


class PlaceFile(_Part):
    """A place in the map [m, rad]."""

    x: Number
    y: Number
    yaw: Number = 0.0


class AfterFile(_Part):
    """What is done with a robot after a run, while the run still holds it; it stands still in any case.

    Args:
        home: Where it drives.
        place: Where it is put, which a simulator can.
        scenario: Path of a scenario from the folder of the lab file, whose one actor the robot is.
        within: How long it may take to drive home, or that scenario [s].
    """

    home: PlaceFile | None = None
    place: PlaceFile | None = None
    scenario: Text | None = None
    within: Annotated[float, Field(gt=0.0, le=3600.0)] = 120.0

    @model_validator(mode="after")
    def _one_of_three(self) -> Self:
        if [self.home, self.place, self.scenario].count(None) != 2:
            raise ValueError(
                "say either where the robot drives `home`, or the `place` where it is put, or a `scenario`"
            )
        return self


class RobotFile(_Part):
    """A robot: the name of a simulator or bridge of this file, and what it is called there.

    Args:
        where: The simulator or bridge.
        called: Its name there; as in this file if it is left out.
        type: What it is. One with a type may be anybody's who wants such a robot.
        can: What it can do, in words of this file's own.
        limits: What runs may ask of it at most.
        before: What has to be so before a run.
        after: What is done after one.
    """

    where: Annotated[Name, Field(alias="in")]
    called: Annotated[Text | None, Field(alias="as")] = None
    type: Word | None = None
    can: tuple[Word, ...] = ()
    limits: LimitsFile = LimitsFile()
    before: BeforeFile = BeforeFile()
    after: AfterFile | None = None


class LabFile(_Part):
    """A lab."""

    simulators: Mapping[Name, SimulatorFile] = Field(default_factory=dict)
    bridges: Mapping[Name, BridgeFile] = Field(default_factory=dict)
    robots: Mapping[Name, RobotFile] = Field(default_factory=dict)
