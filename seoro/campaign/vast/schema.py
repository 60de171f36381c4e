"""Parts of RoboVAST files, version 1, that campaigns have, too; all others are kept as data, to be reported."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

Plain: TypeAlias = bool | int | float | str


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="allow")


class FloatDimension(_Part):
    """Number within bounds."""

    type: Literal["float"]
    low: float
    high: float
    log: bool = False


class IntDimension(_Part):
    """Whole number within bounds."""

    type: Literal["int"]
    low: int
    high: int
    log: bool = False
    step: Annotated[int | None, Field(ge=1)] = None


class ChoiceDimension(_Part):
    """Listed values."""

    type: Literal["choice"]
    values: Annotated[list[Any], Field(min_length=1)]


class BoolDimension(_Part):
    """True or false."""

    type: Literal["bool"]


Dimension: TypeAlias = Annotated[
    FloatDimension | IntDimension | ChoiceDimension | BoolDimension, Field(discriminator="type")
]


class Objective(_Part):
    """Optimised result."""

    name: str
    direction: Literal["maximize", "minimize"] = "maximize"


def _with_value(value: object, keys: Mapping[str, str]) -> object:
    """Unpack a limit that is written as a mapping, `{batches: {value: 3}}`."""
    if not isinstance(value, dict):
        return value
    return {name: each.get(keys.get(name)) if isinstance(each, dict) else each for name, each in value.items()}


class Budget(_Part):
    """Limit of a search: a number of batches, or a wall time [s]."""

    batches: Annotated[int | None, Field(ge=1)] = None
    time: Annotated[float | None, Field(gt=0.0, allow_inf_nan=False)] = None


def _limit(value: object) -> object:
    return _with_value(value, {"batches": "value", "time": "seconds"})


class Extract(_Part):
    """Python that reads results."""

    plugin: str = ""


class Search(_Part):
    """Search over a space."""

    strategy: str
    search_space: Annotated[dict[str, Dimension], Field(min_length=1)]
    objectives: Annotated[list[Objective], Field(min_length=1)]
    per_batch: Annotated[int, Field(ge=1)]
    extract: Extract = Extract()
    budget: list[Annotated[Budget, BeforeValidator(_limit)]] = []
    stopping: list[dict[str, Any]] = []
    seed: int | None = None
    variations: list[Any] = []
    parameters: list[dict[str, Any]] = []
    postprocessing: list[Any] = []
    strategy_parameters: dict[str, Any] = {}


def _named(value: object) -> object:
    """Split an entry `{TYPE: {...}}` of a list of variations."""
    if isinstance(value, str):
        return {"type": value}
    if isinstance(value, dict) and len(value) == 1:
        name, options = next(iter(value.items()))
        return {"type": name, "options": options or {}}
    return value


class Variation(_Part):
    """Entry of a list of variations, by the name of its type."""

    type: str
    options: dict[str, Any] = {}


class Configuration(_Part):
    """Variants of a batch."""

    name: str
    parameters: list[dict[str, Any]] | None = None
    variations: list[Annotated[Variation, BeforeValidator(_named)]] | None = None


class Execution(_Part):
    """Runs of each variant."""

    runs: Annotated[int, Field(ge=1)]
    scenario_file: str = "scenario.osc"
    timeout: Annotated[float | None, Field(gt=0.0)] = None


class VastFile(_Part):
    """A RoboVAST file."""

    version: Literal[1]
    execution: Execution
    configuration: list[Configuration] | None = None
    search: Search | None = None
    metadata: Mapping[str, Any] | None = None
