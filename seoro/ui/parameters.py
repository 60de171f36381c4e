"""Parameters of a scenario, for the form that starts it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from seoro.campaign.space.axes import DIGITS, Axis, Choices
from seoro.campaign.space.finding import find_axes
from seoro.embed.directives import Directives, read_directives
from seoro.embed.scenarios import Scenario, check_file
from seoro.errors import InvalidScenario, UsageError
from seoro.lang.comments import comment_above
from seoro.lang.lower.lower import Plans
from seoro.lang.lower.overrides import ORIGIN as OVERRIDE
from seoro.lang.plan import (
    ActorType,
    EnumType,
    FieldDeclaration,
    ListType,
    PhysicalType,
    Plan,
    PrimitiveType,
    RangeType,
    StructType,
    Structure,
    ValueType,
)

MOST: Final = 300  # parameters
_DEEPEST: Final = 4  # levels of structs


@dataclass(frozen=True)
class Parameter:
    """A parameter of a form.

    Args:
        path: Path, such as `goal.x`.
        type: Type, as the language writes it.
        unit: SI unit of its numbers, for people; empty for others.
        default: Its default, as an expression; empty if it has none.
        doc: Comment above its declaration.
        choices: Its possible values, as expressions; None if they are not listed.
        minimum: Smallest number [SI unit]; None for no bound.
        maximum: Largest number [SI unit].
        required: Whether a run needs a value for it.
    """

    path: str
    type: str
    unit: str = ""
    default: str = ""
    doc: str = ""
    choices: tuple[str, ...] | None = None
    minimum: float | None = None
    maximum: float | None = None
    required: bool = False


@dataclass(frozen=True)
class Form:
    """Form of a scenario.

    Args:
        parameters: Its parameters, in source order.
        robots: Names of its actors.
        directives: Directives of its file.
    """

    parameters: tuple[Parameter, ...] = ()
    robots: tuple[str, ...] = ()
    directives: Directives = field(default_factory=Directives)

    @property
    def data(self) -> dict[str, Any]:
        """JSON data of the form."""
        found = self.directives
        return {
            "parameters": [vars(each) for each in self.parameters],
            "robots": self.robots,
            "needsSimulator": bool(found.simulators or found.world),
            "simulators": found.simulators,
            "world": found.world or "",
            "seed": next(iter(found.seeds), None),
            "timeout": found.timeout,
        }


def read_form(path: Path, shown: str, name: str) -> Form:
    """Read the form of a scenario; its Python is not imported.

    Args:
        path: The file.
        shown: Its name in messages.
        name: Name of the scenario.

    Raises:
        InvalidScenario: The file has errors, or no such scenario.
        UsageError: Its constraints or directives are invalid.
    """
    scenario = check_file(path, import_python=False, name=shown).without_errors()
    plans = Plans(scenario.checked, name)
    plan, missing = plans.draft, plans.missing_values()
    directives = _directives(scenario, name)
    given = dict(directives.overrides)
    axes = {axis.path: axis for axis in find_axes(plan, given)}
    structure = plan.scenarios[plan.entry].structure
    found = _Finding(plan, axes, frozenset(missing), given)
    parameters = [each for part in (plan.globals, structure) for each in found.parameters(part.fields)]
    known = {each.path for each in parameters}
    parameters += [Parameter(path, "", required=True) for path in missing if path not in known]
    return Form(tuple(parameters[:MOST]), tuple(_robots(structure)), directives)


def _directives(scenario: Scenario, name: str) -> Directives:
    found = read_directives(scenario.file, scenario.scenario_lines)
    return found.scenarios.get(scenario.entry(name).line, found.common)


def _robots(structure: Structure) -> Iterator[str]:
    for name, declared in structure.fields.items():
        if isinstance(declared.type, ActorType):
            yield name


@dataclass(frozen=True)
class _Finding:
    """Finds the parameters of a plan.

    Args:
        plan: The plan.
        axes: Ranges of parameters by path.
        missing: Paths of parameters that need a value.
        given: Values of directives by path.
    """

    plan: Plan
    axes: Mapping[str, Axis]
    missing: frozenset[str]
    given: Mapping[str, str]

    def parameters(
        self, fields: Mapping[str, FieldDeclaration], around: str = "", level: int = 0
    ) -> Iterator[Parameter]:
        """Yield the parameters among fields; structs without a default as their fields."""
        for declared in fields.values():
            path = f"{around}{declared.name}"
            is_drawn = path in self.axes  # a constraint replaces the default
            default = self.given.get(path) or ("" if is_drawn else _default(declared))
            if declared.is_variable or isinstance(declared.type, ActorType):
                continue
            structure = self.plan.structures.find(declared.type) if isinstance(declared.type, StructType) else None
            if structure is not None and not default and level < _DEEPEST:
                yield from self.parameters(structure.fields, f"{path}.", level + 1)
            else:
                yield self._parameter(path, declared, " ".join(default.split()))

    def _parameter(self, path: str, declared: FieldDeclaration, default: str) -> Parameter:
        axis = self.axes.get(path)
        low = high = None
        choices = _choices(declared.type)
        if isinstance(axis, Choices):
            choices = axis.texts
        elif axis is not None:
            low, high = (float(f"{bound:.{DIGITS}g}") for bound in (axis.low, axis.high))
        return Parameter(
            path,
            _type_text(declared.type),
            _unit(declared.type),
            default,
            comment_above(declared.span.file, declared.span.line),
            choices,
            low,
            high,
            path in self.missing,
        )


def _default(declared: FieldDeclaration) -> str:
    """Return the text of a default; empty for implied ones."""
    text = "" if declared.default is None else declared.default.span.text
    return "" if text == declared.name else text


def _choices(type_: ValueType) -> tuple[str, ...] | None:
    match type_:
        case EnumType(name, members):
            return tuple(f"{name}!{member}" for member, _ in members)
        case PrimitiveType("bool"):
            return ("true", "false")
        case _:
            return None


def _type_text(type_: ValueType) -> str:
    match type_:
        case ListType(element):
            return f"list of {_type_text(element)}"
        case RangeType(element):
            return f"range of {_type_text(element)}"
        case _:
            return type_.name


def _unit(type_: ValueType) -> str:
    match type_:
        case PhysicalType():
            return type_.unit
        case ListType(element) | RangeType(element):
            return _unit(element)
        case _:
            return ""


def field_of(error: Exception) -> str:
    """Return the path of the parameter whose value is at fault; empty for other errors."""
    if isinstance(error, InvalidScenario):
        spans = [each.primary.span for each in error.diagnostics]
    elif isinstance(error, UsageError):
        spans = [span for span in (error.span, *(place for place, _ in error.places)) if span is not None]
    else:
        return ""
    for span in spans:
        if span.file.name == OVERRIDE:
            return span.file.text.partition("=")[0]
    return ""
