"""A tool: its arguments and result as models, whose schemas agents read."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from seoro.errors import InvalidScenario, UsageError
from seoro.lang.diagnostics import near

A = TypeVar("A", bound="Arguments")


class Arguments(BaseModel):
    """Arguments of a tool; unknown ones are invalid."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Answer(BaseModel):
    """Result of a tool."""

    model_config = ConfigDict(frozen=True)


@dataclass(frozen=True)
class Tool:
    """A tool.

    Args:
        name: Its name.
        description: Its meaning, for agents.
        arguments: Model of its arguments.
        answer: Model of its result.
        call: Calls it with checked arguments.
        reads_only: Whether it changes and starts nothing.
    """

    name: str
    description: str
    arguments: type[Arguments]
    answer: type[Answer]
    call: Callable[[Any], Awaitable[Answer]]
    reads_only: bool = True

    def checked(self, given: Mapping[str, Any]) -> Arguments:
        """Check arguments.

        Raises:
            UsageError: An argument is invalid, missing or unknown.
        """
        try:
            return self.arguments.model_validate(dict(given), strict=True)
        except ValidationError as error:
            raise self._usage_error(error) from None

    def _usage_error(self, error: ValidationError) -> UsageError:
        """Describe the first problem in one sentence."""
        found_errors = error.errors(include_url=False, include_context=False)
        first = next((each for each in found_errors if each["type"] == "extra_forbidden"), found_errors[0])
        place = ".".join(map(str, first["loc"]))
        known = ", ".join(f"`{each}`" for each in self.arguments.model_fields) or "none"
        if first["type"] == "extra_forbidden":
            hint = near(place, self.arguments.model_fields) or f"arguments: {known}"
            return UsageError(f"unknown argument `{place[:100]}` of `{self.name}`", help=hint)
        if first["type"] == "missing":
            return UsageError(f"missing argument `{place}` of `{self.name}`", help=f"arguments: {known}")
        found = repr(first["input"])[:100]
        reason = first["msg"][:1].lower() + first["msg"][1:]
        return UsageError(f"invalid argument `{place}` of `{self.name}`: {reason}; found {found}")


def message_of(error: Exception) -> str:
    """Return the text of an error for agents, with its suggestion and without lines of files."""
    if isinstance(error, InvalidScenario):
        return "the scenario has errors\nhelp: `check_scenarios` lists them"
    if isinstance(error, UsageError):
        place = "" if error.span is None else f"{error.span}: "
        return f"{place}{error.message}" + (f"\nhelp: {error.help}" if error.help else "")
    if isinstance(error, OSError):
        return f"{error.filename}: {error.strerror}" if error.filename else str(error)
    return str(error)
