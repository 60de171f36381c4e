"""Schema of lab files; `docs/how-to/lab.md` has examples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from seoro.files.key_rules import KeyCount, KeyDependency, KeyRules, WithKeyRules

Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]
NodeName = Annotated[str, Field(pattern=r"^[a-z0-9_-]+$")]
Text = Annotated[str, Field(min_length=1, max_length=1000)]


class _Part(WithKeyRules):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SimulatorFile(_Part):
    """A simulator: to start by its name, or to connect to.

    Args:
        simulator: Kind of simulator, such as `mujoco`.
        connect: Zenoh endpoint of a running simulator, or of its router.
        name: Name of the running simulator, if a router has several nodes.
        world: Name of its world, or path of a world file relative to the folder of the lab file.
    """

    simulator: Text | None = None
    connect: Text | None = None
    name: NodeName | None = None
    world: Text | None = None

    key_rules: ClassVar[KeyRules] = (
        KeyCount(
            ("simulator", "connect"),
            (1,),
            "expected either `simulator` (started for the run) or `connect` (an endpoint)",
        ),
        KeyDependency(
            ("name",), "connect", is_needed=True, message="`name` selects a simulator to `connect` to: remove it"
        ),
    )


class BridgeFile(_Part):
    """A running bridge to robots.

    Args:
        connect: Zenoh endpoint of the bridge, or of its router.
        name: Name of the bridge, if a router has several nodes.
    """

    connect: Text
    name: NodeName | None = None


Number = Annotated[float, Field(allow_inf_nan=False)]


class AreaFile(_Part):
    """Rectangle in the map: minimum and maximum of each axis [m]."""

    x: tuple[Number, Number]
    y: tuple[Number, Number]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.x[0] >= self.x[1] or self.y[0] >= self.y[1]:
            raise ValueError("an area is `{x: [FROM, TO], y: [FROM, TO]}`, with FROM before TO")
        return self

    def contains(self, x: float, y: float) -> bool:
        """Whether the area contains a position [m]."""
        return self.x[0] <= x <= self.x[1] and self.y[0] <= y <= self.y[1]

    def __str__(self) -> str:
        return f"x from {self.x[0]:g} to {self.x[1]:g} m, y from {self.y[0]:g} to {self.y[1]:g} m"


class LimitsFile(_Part):
    """Limits of the requests of a run to a robot.

    Args:
        speed: Limit of commanded speeds [m/s].
        area: Area that contains all goals.
    """

    speed: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None
    area: AreaFile | None = None


class BeforeFile(_Part):
    """Conditions of a robot before a run.

    Args:
        battery: Minimum charge, from 0 to 1.
        localised: Whether the robot has to be localised.
        area: Area that contains the robot.
    """

    battery: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    localised: Literal[True] | None = None
    area: AreaFile | None = None


class PlaceFile(_Part):
    """Pose in the map [m, rad]."""

    x: Number
    y: Number
    yaw: Number = 0.0


class AfterFile(_Part):
    """Teardown of a robot after a run, while the run still holds it. The robot is stopped in any case.

    Args:
        home: Pose to drive to.
        place: Pose to move it to; simulators only.
        scenario: Path of a scenario with one actor, relative to the folder of the lab file.
        within: Time limit of the drive or of the scenario [s].
    """

    home: PlaceFile | None = None
    place: PlaceFile | None = None
    scenario: Text | None = None
    within: Annotated[float, Field(gt=0.0, le=3600.0)] = 120.0

    key_rules: ClassVar[KeyRules] = (
        KeyCount(
            ("home", "place", "scenario"),
            (1,),
            "expected one of `home` (a pose to drive to), `place` (a pose to move it to) and `scenario`",
        ),
    )


class RobotFile(_Part):
    """A robot of a simulator or bridge, or a recorded one.

    Args:
        where: Name of the simulator or bridge in this file.
        kind: `bag` for a recorded robot, which runs observe at the times of its bag.
        bag: Path of the ROS 2 bag of a recorded robot, relative to the folder of the lab file.
        namespace: Namespace of a recorded robot in its bag.
        profile: Profile of a recorded robot with other topics than usual: its name, or the path of a `.yaml` file,
            relative to the folder of the lab file.
        name_there: Name of the robot at its node; by default that in this file.
        type: Type of the robot. A robot with a type can be selected by `any:`.
        can: Capabilities, as free words.
        limits: Limits of the requests of runs.
        before: Conditions before a run.
        after: Teardown after a run.
    """

    where: Annotated[Name | None, Field(alias="in")] = None
    kind: Literal["bag"] | None = None
    bag: Text | None = None
    namespace: Annotated[str, Field(pattern=r"^/?([A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*)?$")] = "/"
    profile: Text | None = None
    name_there: Annotated[Text | None, Field(alias="as")] = None
    type: Name | None = None
    can: tuple[Name, ...] = ()
    limits: LimitsFile = LimitsFile()
    before: BeforeFile = BeforeFile()
    after: AfterFile | None = None

    key_rules: ClassVar[KeyRules] = (
        KeyCount(
            ("in", "kind"),
            (1,),
            "expected either `in` (a simulator or bridge) or `kind: bag` (a recorded robot)",
        ),
        KeyCount(
            ("kind", "bag"), (0, 2), "a recorded robot needs both `kind: bag` and `bag`, the path of its bag"
        ),
        KeyDependency(
            ("namespace", "profile"),
            "kind",
            is_needed=True,
            message="{found}: only for a recorded robot: remove it, or add `kind: bag`",
        ),
        KeyDependency(
            ("after", "before", "limits", "as"),
            "kind",
            is_needed=False,
            message="a recorded robot obeys no commands: remove {found}",
        ),
    )


class LabFile(_Part):
    """A lab.

    Args:
        simulators: Simulators, by their names in this file.
        bridges: Bridges to robots, by their names in this file.
        robots: Robots, by the names of their actors in scenarios.
    """

    simulators: Mapping[Name, SimulatorFile] = Field(default_factory=dict)
    bridges: Mapping[Name, BridgeFile] = Field(default_factory=dict)
    robots: Mapping[Name, RobotFile] = Field(default_factory=dict)
