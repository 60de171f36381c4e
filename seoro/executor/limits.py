"""What an executor lets those of each role do: a file that people write.

    everybody:
      allow: [python]     # as `--allow`
      reach: [tcp/192.168.0.7:7447]  # endpoints on other machines
      commands: 50        # a second, on average; ten times as many at once
    roles:
      operator:
        bundle: 256       # [MiB] that a scenario may have
        kept: 512         # [MiB] of files that one has sent, kept to spare sending them again
        free: 2048        # [MiB] of disk that stay free: else nothing is taken
        waiting: 20       # runs of one that wait at most
        running: 2        # runs of one that go on at a time
        time: 3600        # [s] that a run may take, beside what it waits for robots
        memory: 4096      # [MiB] that the processes of a run may have together
        processes: 200    # of a run
        trace: 1024       # [MiB] of a run
        output: 4096      # [MiB] of files that a run leaves
        log: 64           # [MiB] that the processes of a run print
        environment: [FLEET_*]  # variables that runs see, beside those of `environment.py`
        sandbox: required   # or auto: where the system has the means; or off

What a role does not say is as for everybody.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import InvalidUse
from seoro.keys.roles import PEOPLE
from seoro.yaml_files import FileError, Lines, problems, read_text, read_yaml

MEBIBYTE: Final = 1 << 20
BURST: Final = 10.0  # [s] for which commands may be saved up

Count = Annotated[int, Field(ge=1)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Limits(BaseModel):
    """What somebody may do; None leaves it to what holds for everybody, and there to seoro."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    allow: tuple[str, ...] | None = None
    reach: tuple[str, ...] | None = None
    commands: Positive | None = None
    bundle: Annotated[int, Field(ge=1, le=wire.MAX_BUNDLE // MEBIBYTE)] | None = None
    kept: Count | None = None
    free: Annotated[int, Field(ge=0)] | None = None
    waiting: Count | None = None
    running: Count | None = None
    time: Positive | None = None
    memory: Count | None = None
    processes: Count | None = None
    trace: Count | None = None
    output: Count | None = None
    log: Count | None = None
    environment: tuple[str, ...] | None = None
    sandbox: Literal["required", "auto", "off"] | None = None

    def over(self, other: Limits) -> Limits:
        """These, and those of another where these say nothing."""
        return other.model_copy(update=self.model_dump(exclude_none=True))

    @property
    def allowed(self) -> tuple[str, ...]:
        """What scenarios may do that they else may not."""
        return self.allow or ()

    @property
    def reached(self) -> tuple[str, ...]:
        """Endpoints on other machines that scenarios may reach."""
        return self.reach or ()

    @property
    def variables(self) -> tuple[str, ...]:
        """Names, or patterns of names, of further environment variables that runs see."""
        return self.environment or ()

    @property
    def largest_file(self) -> int:
        """How large a file may get that a run writes [bytes]."""
        assert self.output is not None, "the limits of an executor have it"
        return self.output * MEBIBYTE

    @property
    def largest_memory(self) -> int | None:
        """Memory that the processes of a run may have together [bytes]; None for no limit."""
        return None if self.memory is None else self.memory * MEBIBYTE

    @property
    def kept_of_one(self) -> int:
        """How much is kept of one, beside their runs [bytes]: a scenario at least, else none could be sent."""
        assert self.kept is not None, "the limits of an executor have it"
        return max(self.kept, self.bundle or 0) * MEBIBYTE

    @property
    def rate(self) -> tuple[float, float]:
        """Commands a second, and at once."""
        assert self.commands is not None, "the limits of an executor have it"
        return self.commands, BURST * self.commands


_BUNDLE: Final = wire.MAX_BUNDLE // MEBIBYTE
_MEMORY: Final = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // MEBIBYTE
DEFAULT: Final = Limits(
    commands=1000.0,
    bundle=_BUNDLE,
    kept=2 * _BUNDLE,
    waiting=1000,
    time=86_400.0,
    memory=max(1, _MEMORY // 2),
    processes=1000,
    trace=1024,
    output=4096,
    log=64,
    sandbox="auto",
)


class Policy(BaseModel):
    """The limits of an executor."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    everybody: Limits = Limits()
    roles: Mapping[str, Limits] = Field(default_factory=dict)

    def of(self, role: str) -> Limits:
        """What those of a role may do; of an empty one, those who have no keys."""
        return self.roles.get(role, Limits()).over(self.everybody).over(DEFAULT)

    def also(self, allowed: frozenset[str], reach: frozenset[str] = frozenset()) -> Policy:
        """The same, and something that everybody may do, and endpoints that everybody may reach."""

        def extended(limits: Limits, allow: tuple[str, ...] | None, to: tuple[str, ...] | None) -> Limits:
            more = Limits(
                allow=None if allow is None else tuple(sorted({*allow, *allowed})),
                reach=None if to is None else tuple(sorted({*to, *reach})),
            )
            return more.over(limits)

        roles = {name: extended(limits, limits.allow, limits.reach) for name, limits in self.roles.items()}
        everybody = extended(self.everybody, self.everybody.allowed, self.everybody.reached)
        return self.model_copy(update={"everybody": everybody, "roles": roles})

    @property
    def allowed(self) -> frozenset[str]:
        """All that somebody may do."""
        return frozenset({*self.everybody.allowed}.union(*(limits.allowed for limits in self.roles.values())))

    @property
    def sandboxes_nobody(self) -> bool:
        """Whether nobody's runs may be sandboxed."""
        roles = all(limits.sandbox in (None, "off") for limits in self.roles.values())
        return self.everybody.sandbox == "off" and roles

    @property
    def requires_sandbox(self) -> bool:
        """Whether somebody's runs must be sandboxed."""
        return any(limits.sandbox == "required" for limits in (self.everybody, *self.roles.values()))

    @property
    def variables(self) -> tuple[str, ...]:
        """Names, or patterns of names, of environment variables that somebody's runs see."""
        each = (self.everybody, *self.roles.values())
        return tuple(sorted({name for limits in each for name in limits.variables}))


def limit_reached(what: str, name: str) -> str:
    """Text for a run that was ended by a limit.

    Args:
        what: The limit and its value.
        name: Of the field of `Limits` that raises it.
    """
    return f"limit reached: {what}; to raise it, set `{name}` in the executor's policy (`seoro serve --policy`)"


def check_submission(submission: wire.Submission, limits: Limits, waiting: int) -> None:
    """Check that a run keeps within the limits of its submitter.

    Args:
        submission: The run.
        limits: Of who submits it.
        waiting: How many of theirs wait.

    Raises:
        RequestRefused: It does not.
    """
    size = sum(file.size for file in submission.manifest.files)
    if limits.bundle is not None and size > limits.bundle * MEBIBYTE:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the scenario has {size / MEBIBYTE:.1f} MiB of files, more than the {limits.bundle} MiB that it may",
        )
    if limits.waiting is not None and waiting >= limits.waiting:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"{waiting} of your runs wait already, which is as many as may: try again later",
        )


def read_policy(path: Path) -> Policy:
    """The policy in a file.

    Raises:
        InvalidUse: There is none, or it is wrong.
    """
    try:
        text = read_text(path)
        data = read_yaml(text, str(path))
        policy = Policy.model_validate({} if data is None else data)
    except FileError as error:
        raise InvalidUse(str(error)) from error
    except ValidationError as error:
        raise InvalidUse(problems(error, Lines(text, str(path)), Policy)) from error
    known = [role.value for role in PEOPLE]
    for role in policy.roles:
        if role not in known:
            raise InvalidUse(
                f"{Lines(text, str(path)).at(['roles', role])}: nobody submits as '{role}'",
                help=f"there are {', '.join(known)}",
            )
    return policy
