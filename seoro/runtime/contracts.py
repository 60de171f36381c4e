"""The seams of the runtime: what it needs from clocks, observers and backends, what it offers to modifiers, and
who calls what when.

Implementations live elsewhere: clocks in `clock.py`, observers in `trace.py` and with users, backends in
`seoro.bridges`. Units are SI, angles radians; poses are in the frame `map` unless a parameter says otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from enum import Enum
from typing import Any, NoReturn, Protocol

import anyio

from seoro.errors import BackendError
from seoro.lang.frozen import Value
from seoro.runtime.verdict import Outcome

# ---------------------------------------------------------------- time


class Clock(Protocol):
    """The time of a run, in seconds since its start. Called by the agenda only."""

    @property
    def deterministic(self) -> bool:
        """Whether the runtime decides when time moves; then it stands still while anything is at work."""
        ...

    @property
    def name(self) -> str:
        """`real`, `virtual` or `sim`; stands in the trace."""
        ...

    def start(self) -> None:
        """Called once, when the run starts: this is time zero."""
        ...

    def now(self) -> float:
        """Read when an instant begins. Never goes back."""
        ...

    def skip(self, due: float) -> bool:
        """Called when an instant has settled: be at `due` [s] at once, if nothing has to be awaited for that.

        Returns:
            Whether it is; otherwise `pass_time` may be called.
        """
        ...

    async def pass_time(self, due: float | None, interrupt: anyio.Event) -> None:
        """Called when an instant has settled: let time pass until `due`, or until something happens.

        Args:
            due: When the next timer is due [s]; None if there is none.
            interrupt: Set when something arrives from outside; return soon then.
        """
        ...


class TimeServer(Protocol):
    """A simulator that is granted time."""

    async def advance(self, until: float) -> float:
        """Simulate to `until` [s since the run's start], or to the first thing worth telling before it.

        Everything that happened is reported before this returns the time that was reached.

        Raises:
            BackendLost: The simulator is gone.
        """
        ...


# ---------------------------------------------------------------- observation


class Observer(Protocol):
    """Sees every record of a run, in order. Must not block; when it raises, the run ends as an error."""

    def record(self, record: dict[str, Any]) -> None:
        """Called with each record; it is not to be changed."""
        ...


# ---------------------------------------------------------------- modifiers


class Child(Protocol):
    """The behavior that a modifier is applied to, with the modifiers that stand closer to it."""

    async def run(self, limit: float | None = None, interrupt: Interrupt | None = None) -> Outcome | None:
        """Called by a modifier: run the behavior from its start, again if it has run before.

        A modifier that is cancelled while it waits here has cancelled the behavior, too.

        Args:
            limit: When the behavior is to be cancelled [s after it is started, on the run's clock]; it acts when
                the instant has otherwise settled, so that 0 leaves the behavior the instant in which it starts.
            interrupt: What may end it before its end.

        Returns:
            How the behavior ended, succeeded or failed; None if it was cancelled at the limit or by the interrupt,
            and has cleaned up.
        """
        ...


class Interrupt:
    """Ends a behavior that a modifier runs, at once and with a reason; for what is not a matter of time."""

    def __init__(self) -> None:
        self.reason = ""
        self._act: Callable[[], None] | None = None

    def when_made(self, act: Callable[[], None] | None) -> None:
        """Have something called when it is made, in place of what was to be called before."""
        self._act = act

    def make(self, reason: str) -> None:
        """End the behavior; only the first call has an effect."""
        if not self.reason:
            self.reason = reason
            if self._act is not None:
                self._act()


class ModifierContext(Protocol):
    """The run, as one application of a modifier sees it. Times are those of the run's clock."""

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        ...

    def log(self, message: str, level: str = "info") -> None:
        """Write a message into the trace; levels are `debug`, `info`, `warning` and `error`."""
        ...

    async def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""
        ...

    async def hold(self) -> NoReturn:
        """Wait until the modifier is cancelled: the modified behavior has no end of its own."""
        ...

    def allow_contact(self, entities: Sequence[str]) -> AbstractContextManager[None]:
        """Let robots touch entities within the behavior while the block lasts; anything if none is named."""
        ...

    def forbid_contact(
        self, robots: Sequence[str], allowed: Sequence[str], interrupt: Interrupt, *, also_struck: bool
    ) -> AbstractContextManager[None]:
        """Interrupt the behavior when a robot strikes something that is not allowed, while the block lasts.

        Args:
            robots: Names of robots, as their simulator calls them; all in which actors live if none is named.
            allowed: What they may touch, besides what is allowed around the behavior and within it.
            interrupt: Of the modified behavior.
            also_struck: Whether contacts count in which others struck the robot.

        Raises:
            ActionFailed: No actor lives in a robot of such a name.
        """
        ...


# ---------------------------------------------------------------- geometry


class Position3D(Value):
    """Position [m]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Orientation3D(Value):
    """Roll, pitch, yaw [rad], yaw first (ISO 8855)."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Pose3D(Value):
    """Position and orientation."""

    position: Position3D = Position3D()
    orientation: Orientation3D = Orientation3D()


class TranslationalVelocity3D(Value):
    """Velocity [m/s]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class OrientationRate3D(Value):
    """Rates of roll, pitch, yaw [rad/s]."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Velocity6D(Value):
    """Translational and angular velocity."""

    translational: TranslationalVelocity3D = TranslationalVelocity3D()
    angular: OrientationRate3D = OrientationRate3D()


# ---------------------------------------------------------------- backends


class GoalStatus(Enum):
    """How something that a backend works on ended."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Report(Value):
    """A backend's word that a goal has ended, or that what was watched for has happened.

    A goal is `interrupted` if the backend ended it for a reason of its own, such as a lost connection: no action
    sees that report (`ActionContext.report` raises instead), so none can take it for a failure of the robot.
    """

    status: GoalStatus
    message: str = ""
    interrupted: bool = False


Reporter = Callable[[Report], None]
"""Called by a backend at most once, on the event loop, between instants."""


class Contact(Value):
    """Two entities touch, as a backend reports it.

    Args:
        first: Name of one.
        second: Name of the other.
        time: Of the backend's clock [s].
        strikers: Who moved into the other; None if the backend cannot say.
        position: Where [m]; None if the backend cannot say.
        held: What of the two a robot holds, and which robot.
    """

    first: str
    second: str
    time: float
    strikers: tuple[str, ...] | None = None
    position: tuple[float, ...] | None = None
    held: Mapping[str, str] = {}

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> Contact:
        """The contact in the arguments of what happened."""
        strikers, position = arguments.get("strikers"), arguments.get("position")
        return cls(
            arguments["first"],
            arguments["second"],
            arguments["time"],
            None if strikers is None else tuple(strikers),
            None if position is None else tuple(position),
            arguments.get("held") or {},
        )

    def sides(self, robot: str) -> tuple[str, str | None]:
        """What of a robot touches, itself or what it holds, and the other; None if it is not among the two."""
        for mine, other in ((self.first, self.second), (self.second, self.first)):
            if mine == robot:
                return mine, other
        for mine, other in ((self.first, self.second), (self.second, self.first)):
            if self.held.get(mine) == robot:
                return mine, other
        return "", None

    def is_struck_by(self, robot: str) -> bool:
        """Whether a robot has moved into the other, or may have, where nobody can say."""
        return self.strikers is None or robot in self.strikers


Happened = Callable[[str, Mapping[str, Any]], None]
"""Called by a backend with the name and arguments of what happens unasked, such as a contact, or a `WARNING`."""

WARNING = "warning"
DEPARTURE = "left_world"
"""Event of a robot that left its world, which fails the run; its argument `reason` is that of the verdict."""

"""Names what people have to know: its `message` is a warning of the run, and no event."""

Lost = Callable[[BackendError], None]
"""Called by a backend, on the event loop, when it is gone, with the reason, or when somebody has stopped all that
moves (`BackendStopped`)."""


class Backend(Protocol):
    """Where actors live: a simulator node, or a bridge to robots. Opened and closed by who starts the run.

    A backend also implements those of the protocols in `capabilities.py` that it can serve.
    Their requests take no time of the
    run's clock; what lasts is reported later. Each raises `BackendRefused` when the backend says no, with its
    reason, and `BackendLost` when it is gone.
    """

    @property
    def name(self) -> str:
        """How messages call it."""
        ...

    def home_of(self, actor: str, types: Sequence[str]) -> str | None:
        """Called once for each actor at instantiation: the backend's own name for it, or None.

        Args:
            actor: Name of the actor in the scenario.
            types: Its type and what that inherits, nearest first.
        """
        ...

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Called once, before the first instant, when the run has been instantiated."""
        ...

    async def end_run(self) -> None:
        """Called once, after the last instant and on every path: leave every robot standing still."""
        ...
