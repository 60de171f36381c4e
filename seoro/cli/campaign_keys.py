"""Schema of campaign files; `docs/how-to/campaign_files.md` has examples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, PlainValidator, Tag

Text = Annotated[str, Field(min_length=1, max_length=1000)]
Plain: TypeAlias = bool | int | float | str


def _check_plain(value: object) -> Plain:
    if isinstance(value, bool | int | float | str):
        return value
    raise ValueError("expected a text, a number, true or false")


def _check_setting(value: object) -> Plain | list[Plain]:
    if isinstance(value, list):
        return [_check_plain(each) for each in value]
    return _check_plain(value)


def _with_name(value: object) -> object:
    return {"name": value} if isinstance(value, str) else value


def _with_strategy(value: object) -> object:
    return {value: None} if isinstance(value, str) else value


def _as_list(value: object) -> object:
    return value if isinstance(value, list) else [value]


def _rule_kind(value: object) -> str:
    return "test" if isinstance(value, dict | RateKeys) else "rule"


Scalar: TypeAlias = Annotated[Plain, PlainValidator(_check_plain, json_schema_input_type=Plain)]
Setting: TypeAlias = Annotated[
    Plain | list[Plain], PlainValidator(_check_setting, json_schema_input_type=Plain | list[Plain])
]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class SimulatorKeys(_Part):
    """Simulator of the runs, or only its name.

    Args:
        name: Simulator to start, as of `--sim`.
        connect: Zenoh endpoint of a running simulator, as of `--connect`.
        world: Name of its world, or path of a world file.
        rate: Simulated seconds per second, or `max`.
        snapshot: Path of a saved state to start from, as of `--from-snapshot`.
        model_path: Folders to search first for models.
    """

    name: Text | None = None
    connect: Text | None = None
    world: Text | None = None
    rate: Literal["max"] | float | None = None
    snapshot: Text | None = None
    model_path: tuple[Text, ...] = ()


class RateKeys(_Part):
    """Stopping rule that decides about the pass rate.

    Args:
        rate: Good pass rate, 0 to 1.
        against: Bad pass rate, 0 to 1; by default all below the good one, which takes more runs.
        errors: Probability of a wrong decision between two rates, 0 to 1; by default 0.05.
    """

    rate: float
    against: float | None = None
    errors: float | None = None

    @property
    def text(self) -> str:
        """The rule in the notation of `--until`."""
        errors = "" if self.errors is None else f" errors {self.errors:g}"
        against = "" if self.against is None else f" vs {self.against:g}"
        return f"rate >= {self.rate:g}{against}{errors}"


Rule: TypeAlias = Annotated[
    Annotated[Text, Tag("rule")] | Annotated[RateKeys, Tag("test")], Discriminator(_rule_kind)
]


class CampaignKeys(BaseModel):
    """A campaign. Other keys are options of `seoro campaign run`, such as `seed`, `repeat` or `output_dir`.

    Args:
        scenario: Path of the scenario file.
        name: Scenario to run, if the file has several.
        simulator: Simulator of the runs, or only its name.
        strategy: Name of the strategy, or a mapping with its name and its options. The value of the name is that
            of `levels` for `grid`, of `strength` for `pairwise`, and else of `runs`.
        until: Stopping rules.
        engine: Options for the place of the runs.
        set: Values of parameters by path, as expressions.
    """

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, Setting]

    scenario: Text
    name: Text | None = None
    simulator: Annotated[
        SimulatorKeys, BeforeValidator(_with_name, json_schema_input_type=Text | SimulatorKeys)
    ] = SimulatorKeys()
    strategy: Annotated[
        Mapping[Text, Scalar | None],
        BeforeValidator(_with_strategy, json_schema_input_type=Text | Mapping[Text, Scalar | None]),
    ] = Field(default_factory=dict)
    until: Annotated[
        tuple[Rule, ...], BeforeValidator(_as_list, json_schema_input_type=Rule | tuple[Rule, ...])
    ] = ()
    engine: Mapping[Text, Setting] = Field(default_factory=dict)
    set: Mapping[Text, Scalar] = Field(default_factory=dict)
