"""Rules on the keys of a part of a file, declared once: its model checks them, and its JSON Schema has them.

A key with the value `null` counts as missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from itertools import combinations
from typing import Any, ClassVar, Protocol, Self, TypeAlias

from pydantic import BaseModel, model_validator

from seoro.deferred import dataclass

Schema = dict[str, Any]


class KeyRule(Protocol):
    """A rule on the keys of a part."""

    def problem(self, given: AbstractSet[str]) -> str:
        """Return how given keys break the rule; empty if they do not."""

    @property
    def schema(self) -> Schema:
        """The rule as a JSON Schema of draft 7."""


@dataclass(frozen=True)
class KeyCount:
    """A number of given keys.

    Args:
        keys: Keys that are counted.
        numbers: Allowed numbers.
        message: Message on another number; `{found}` stands for the given keys.
    """

    keys: tuple[str, ...]
    numbers: tuple[int, ...]
    message: str

    def problem(self, given: AbstractSet[str]) -> str:
        """See `KeyRule`."""
        found = [key for key in self.keys if key in given]
        return "" if len(found) in self.numbers else self.message.format(found=" and ".join(found) or "none")

    @property
    def schema(self) -> Schema:
        """See `KeyRule`."""
        forbidden = {*range(len(self.keys) + 1)}.difference(self.numbers)
        chosen = (keys for number in sorted(forbidden) for keys in combinations(self.keys, number))
        broken = [{"allOf": [_presence(key, key in keys) for key in self.keys]} for keys in chosen]
        return _forbidden({"anyOf": broken}, self.message, self.keys)


@dataclass(frozen=True)
class KeyDependency:
    """Keys that stand only beside another key, or only without it.

    Args:
        keys: Keys of the rule.
        other: The other key.
        is_needed: Whether they need the other key, or exclude it.
        message: Message on keys that break the rule, for which `{found}` stands.
    """

    keys: tuple[str, ...]
    other: str
    is_needed: bool
    message: str

    def problem(self, given: AbstractSet[str]) -> str:
        """See `KeyRule`."""
        found = [key for key in self.keys if key in given]
        is_broken = found and (self.other in given) is not self.is_needed
        return self.message.format(found=", ".join(found)) if is_broken else ""

    @property
    def schema(self) -> Schema:
        """See `KeyRule`."""
        some = {"anyOf": [_presence(key, True) for key in self.keys]}
        return _forbidden({"allOf": [_presence(self.other, not self.is_needed), some]}, self.message, self.keys)


def _forbidden(broken: Schema, message: str, keys: Sequence[str]) -> Schema:
    """Return the schema of parts that another schema does not fit.

    No part is null. Editors show the message of a type, and have none for `not`.
    """
    return {"if": broken, "then": {"type": "null", "errorMessage": message.format(found=", ".join(keys))}}


def _presence(key: str, is_given: bool) -> Schema:
    """Return the schema of parts with a key, or without it."""
    given = {"required": [key], "properties": {key: {"not": {"type": "null"}}}}
    return given if is_given else {"not": given}


KeyRules: TypeAlias = tuple[KeyRule, ...]


class WithKeyRules(BaseModel):
    """Base of models with rules on their keys.

    Attributes:
        key_rules: The rules, by the keys in the file.
    """

    key_rules: ClassVar[KeyRules] = ()

    @model_validator(mode="after")
    def _follow_key_rules(self) -> Self:
        given = {
            field.alias or name
            for name, field in type(self).model_fields.items()
            if name in self.model_fields_set and getattr(self, name) is not None
        }
        for rule in self.key_rules:
            if problem := rule.problem(given):
                raise ValueError(problem)
        return self
