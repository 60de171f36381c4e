"""Settings of a debugged run, as in `launch.json` of VS Code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from seoro.embed.options import Options, Simulator
from seoro.errors import UsageError
from seoro.lang.diagnostics import near
from seoro.runtime.debug.debugger import Debugger

# Settings that editors add, or read themselves.
_OF_EDITORS: Final = frozenset({
    "name", "type", "request", "presentation", "preLaunchTask", "postDebugTask", "internalConsoleOptions",
    "debugServer", "serverReadyAction", "noDebug", "suppressMultipleSessionWarning",
})  # fmt: skip


class Launch(BaseModel):
    """Settings of a run.

    Attributes:
        program: Scenario file.
        scenario: Name of the scenario, if the file has several.
        seed: Random seed.
        sim: Name of a simulator to start, such as `mujoco`; empty for the virtual clock.
        world: Name or file of the world.
        rate: Simulated seconds per second; None for as fast as possible.
        set: Values of parameters, as expressions of the language.
        cwd: Folder of relative paths.
        stop_on_entry: Whether the run pauses before its first behavior.
        output: Folder for the trace and other results of the run; None to keep none.
    """

    model_config = ConfigDict(extra="ignore", frozen=True)

    program: Path
    scenario: str | None = None
    seed: int | None = None
    sim: str = ""
    world: str | None = None
    rate: float | None = Field(default=None, gt=0)
    set: dict[str, str | int | float | bool] = {}
    cwd: Path | None = None
    stop_on_entry: bool = Field(default=False, alias="stopOnEntry")
    clock: Literal["virtual", "sim"] | None = None
    output: Path | None = None

    @property
    def output_folder(self) -> Path | None:
        """The folder for results, as an absolute path; None for none."""
        return None if self.output is None else (self.cwd or Path.cwd()) / self.output

    @property
    def file(self) -> Path:
        """The scenario file, as an absolute path."""
        return (self.cwd or Path.cwd()) / self.program

    def options(self, debugger: Debugger) -> Options:
        """Return the options of the run."""
        simulator = None
        if self.sim:
            simulator = Simulator(self.sim, world=self.world, rate=self.rate if self.rate is not None else "max")
        return Options(
            name=self.scenario,
            seed=self.seed,
            overrides={path: _expression(value) for path, value in self.set.items()},
            clock=self.clock or ("sim" if self.sim else "virtual"),
            simulator=simulator,
            output_directory=self.output_folder,
            debugger=debugger,
        )


def _expression(value: str | float | bool) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def read_launch(arguments: Mapping[str, Any]) -> tuple[Launch, tuple[str, ...]]:
    """Read the arguments of a `launch` request; return warnings about unknown ones, too.

    Raises:
        UsageError: A setting is missing or invalid.
    """
    try:
        found = Launch.model_validate(arguments)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the settings"
        raise UsageError(f"`{where}` of the launch configuration: {first['msg']}") from error
    known = {field.alias or name for name, field in Launch.model_fields.items()}
    unknown = [name for name in arguments if name not in known | _OF_EDITORS and not name.startswith("__")]
    return found, tuple(
        f"unknown setting `{name}` of the launch configuration is ignored" + _hint(name, known) for name in unknown
    )


def _hint(name: str, known: set[str]) -> str:
    hint = near(name, sorted(known))
    return f"; {hint}" if hint else ""
