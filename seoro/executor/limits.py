"""Policy of an executor: limits for each role, from a YAML file (`docs/how-to/keys.md`).

Missing fields of a role are taken from `everybody`, then from the defaults.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import UsageError
from seoro.files.yaml_lines import FileError, Lines, read_text, read_yaml, validate
from seoro.security.keys.roles import PEOPLE

MEBIBYTE: Final = 1 << 20
BURST: Final = 10.0  # [s] of unused commands that may be sent in a burst

Count = Annotated[int, Field(ge=1)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Limits(BaseModel):
    """Limits of a client; None for the limit of `everybody`, and there for the default.

    Attributes:
        allow: Permissions of scenarios, as of `--allow`.
        reach: Endpoints on other machines that scenarios may reach.
        commands: Requests per second, on average; ten times as many in a burst.
        bundle: Size of a scenario with its files [MiB].
        kept: Size of sent files that are kept for each client [MiB].
        free: Disk space that stays free [MiB].
        waiting: Waiting runs of a client.
        running: Active runs of a client.
        time: Duration of a run, without its wait for robots [s].
        memory: Memory of all processes of a run [MiB].
        processes: Processes of a run.
        trace: Size of the trace of a run [MiB].
        output: Size of the output files of a run [MiB].
        log: Size of the printed output of a run [MiB].
        environment: Further variables of runs, by name or pattern (see `environment.py`).
        sandbox: `required`, `auto` (if the system supports sandboxes) or `off`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    allow: tuple[str, ...] | None = None  # permissions, as `--allow`
    reach: tuple[str, ...] | None = None  # endpoints on other machines
    commands: Positive | None = None  # requests per second on average; ten times as many in a burst
    bundle: Annotated[int, Field(ge=1, le=wire.MAX_BUNDLE // MEBIBYTE)] | None = (
        None  # [MiB] of a scenario with its files
    )
    kept: Count | None = None  # [MiB] of sent files that are kept for each client
    free: Annotated[int, Field(ge=0)] | None = None  # [MiB] of the disk that stay free
    waiting: Count | None = None  # waiting runs of a client
    running: Count | None = None  # running runs of a client
    time: Positive | None = None  # [s] of a run, without waits for robots
    memory: Count | None = None  # [MiB] of all processes of a run
    processes: Count | None = None  # of a run
    trace: Count | None = None  # [MiB] of a run
    output: Count | None = None  # [MiB] output files of a run
    log: Count | None = None  # [MiB] printed output of a run
    environment: tuple[str, ...] | None = None  # variables that runs see, besides those of `environment.py`
    sandbox: Literal["required", "auto", "off"] | None = None  # `auto`: if the system supports it

    def over(self, other: Limits) -> Limits:
        """Return these limits, with missing ones from `other`."""
        return other.model_copy(update=self.model_dump(exclude_none=True))

    @property
    def allowed(self) -> tuple[str, ...]:
        """Names of permissions for scenarios."""
        return self.allow or ()

    @property
    def reached(self) -> tuple[str, ...]:
        """Endpoints on other machines that scenarios may reach."""
        return self.reach or ()

    @property
    def variables(self) -> tuple[str, ...]:
        """Names or patterns of further environment variables that runs see."""
        return self.environment or ()

    @property
    def largest_file(self) -> int:
        """Size limit of a file that a run writes [bytes]."""
        assert self.output is not None, "set by the default limits"
        return self.output * MEBIBYTE

    @property
    def largest_memory(self) -> int | None:
        """Memory limit of all processes of a run [bytes]; None for no limit."""
        return None if self.memory is None else self.memory * MEBIBYTE

    @property
    def blob_quota(self) -> int:
        """Size of files that are kept for a client [bytes]; large enough for one scenario."""
        assert self.kept is not None, "set by the default limits"
        return max(self.kept, self.bundle or 0) * MEBIBYTE

    @property
    def rate(self) -> tuple[float, float]:
        """Rate [1/s] and burst of commands."""
        assert self.commands is not None, "set by the default limits"
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
    """Common limits of an executor, and limits of each role."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    everybody: Limits = Limits()
    roles: Mapping[str, Limits] = Field(default_factory=dict)

    def of(self, role: str) -> Limits:
        """Return the limits of a role; an empty role is that of clients without keys."""
        return self.roles.get(role, Limits()).over(self.everybody).over(DEFAULT)

    def also(self, allowed: frozenset[str], reach: frozenset[str] = frozenset()) -> Policy:
        """Return this policy with further permissions and endpoints for all roles."""

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
    def _all(self) -> tuple[Limits, ...]:
        return (self.everybody, *self.roles.values())

    @property
    def allowed(self) -> frozenset[str]:
        """Permissions of any role."""
        return frozenset(name for limits in self._all for name in limits.allowed)

    @property
    def sandboxes_nobody(self) -> bool:
        """Whether sandboxes are off for all roles."""
        roles = all(limits.sandbox in (None, "off") for limits in self.roles.values())
        return self.everybody.sandbox == "off" and roles

    @property
    def requires_sandbox(self) -> bool:
        """Whether sandboxes are required for any role."""
        return any(limits.sandbox == "required" for limits in self._all)

    @property
    def variables(self) -> tuple[str, ...]:
        """Names or patterns of environment variables that runs of any role see."""
        return tuple(sorted({name for limits in self._all for name in limits.variables}))


def limit_reached(what: str, name: str) -> str:
    """Return the message of a run that was ended by a limit.

    Args:
        what: Description of the limit, with its value.
        name: Field of `Limits` that sets it.
    """
    return f"limit reached: {what}; to raise it, set `{name}` in the executor's policy (`seoro serve --policy`)"


def check_submission(submission: wire.Submission, limits: Limits, waiting: int) -> None:
    """Check that a submission is within the limits of its client.

    Args:
        submission: The submission.
        limits: Limits of the client.
        waiting: Number of waiting runs of the client.

    Raises:
        RequestRefused: A limit is exceeded.
    """
    size = sum(file.size for file in submission.manifest.files)
    if limits.bundle is not None and size > limits.bundle * MEBIBYTE:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the files of the scenario have {size / MEBIBYTE:.1f} MiB; the limit of this executor is "
            f"{limits.bundle} MiB (`bundle` in its policy)",
        )
    if limits.waiting is not None and waiting >= limits.waiting:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"{waiting} of your runs are already waiting, which is the limit (`waiting` in the policy): try again "
            "later",
        )


def read_policy(path: Path) -> Policy:
    """Read a policy file.

    Raises:
        UsageError: The file is missing or invalid.
    """
    try:
        text = read_text(path)
        data, lines = read_yaml(text, str(path)), Lines(text, str(path))
        policy = validate(Policy, {} if data is None else data, lines)
    except FileError as error:
        raise UsageError(str(error)) from error
    known = [role.value for role in PEOPLE]
    for role in policy.roles:
        if role not in known:
            raise UsageError(f"{lines.at(['roles', role])}: unknown role '{role}' (roles: {', '.join(known)})")
    return policy
