"""The form of a lab file.

simulators:
  hall: {simulator: mujoco, world: hall}      # started for the run; or {connect: tcp/127.0.0.1:7450}
bridges:
  floor: {connect: tcp/127.0.0.1:7460}        # a bridge to robots that is running
robots:                                       # of each actor, where it lives and what it is called there
  leader: {in: floor, as: turtlebot4}
  follower: {in: hall, as: second}
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Self

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


class RobotFile(_Part):
    """Where an actor lives: the name of a simulator or bridge of this file, and of a robot there."""

    where: Annotated[Name, Field(alias="in")]
    called: Annotated[Text, Field(alias="as")]


class LabFile(_Part):
    """A lab."""

    simulators: Mapping[Name, SimulatorFile] = Field(default_factory=dict)
    bridges: Mapping[Name, BridgeFile] = Field(default_factory=dict)
    robots: Mapping[Name, RobotFile] = Field(default_factory=dict)
