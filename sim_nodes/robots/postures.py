"""Postures: named positions of a robot's joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Annotated

from pydantic import BeforeValidator, Field, PlainSerializer

from seoro.bridges.wire.refusal import name_list
from sim_nodes.files import Declared

MAX_POSTURES = 100


class Posture(Declared):
    """Positions of joints by name or pattern [rad], [m]; the last pattern that matches a joint counts."""

    name: str = Field(min_length=1, max_length=100)
    positions: tuple[tuple[str, float], ...] = Field(min_length=1)

    def of(self, joints: Sequence[str]) -> dict[str, float]:
        """Return the positions of those of `joints` that it names [rad], [m].

        Raises:
            ValueError: A pattern matches none of them.
        """
        return positions_by_joint(self.positions, joints, f"postures.{self.name}")

    def renamed(self, prefix: str) -> Posture:
        """Return the posture of joints with a prefix before their names."""
        return Posture(
            name=self.name, positions=tuple((f"{prefix}{each}", value) for each, value in self.positions)
        )


def positions_by_joint(
    positions: Iterable[tuple[str, float]], joints: Sequence[str], what: str
) -> dict[str, float]:
    """Return the positions of those of `joints` that names or patterns match; the last that matches counts.

    Args:
        positions: Positions by name or pattern [rad], [m].
        joints: Names of joints.
        what: Key of the file, for messages.

    Raises:
        ValueError: A pattern matches none of them.
    """
    found: dict[str, float] = {}
    for pattern, position in positions:
        matched = [joint for joint in joints if fnmatchcase(joint, pattern)]
        if not matched:
            raise ValueError(
                f"`{what}` names the unknown joint {pattern!r}; expected names or patterns of {name_list(joints)}"
            )
        found |= dict.fromkeys(matched, position)
    return found


def _read(value: object) -> object:
    """Read postures from a mapping of mappings; other values are returned unchanged."""
    if not isinstance(value, Mapping):
        return value
    for name, positions in value.items():
        if not isinstance(positions, Mapping) or not positions:
            raise ValueError(
                f"invalid posture {name!r}; expected positions by joint or pattern, such as {{'*_knee': 1.2}}"
            )
    return tuple({"name": name, "positions": tuple(joints.items())} for name, joints in value.items())


def postures_form(postures: Iterable[Posture]) -> dict[str, dict[str, float]]:
    """Return postures as the content of a file."""
    return {posture.name: dict(posture.positions) for posture in postures}


Postures = Annotated[
    tuple[Posture, ...],
    BeforeValidator(_read, json_schema_input_type=Mapping[str, Mapping[str, float]]),
    PlainSerializer(postures_form),
    Field(max_length=MAX_POSTURES),
]
"""Postures in a file: positions by joint or pattern, by name of the posture."""
