"""State of objects that change over time: saving and restoring.

A class names the attributes to keep:

    class Thermometer(Stateful):
        STATE = ("_last", "_filter")

Such an attribute is data that `codec` accepts, a `Stateful`, or a dictionary or sequence of such parts. Parts are
made with their owner and restored in place. What follows from the declaration of a robot or a world is not state:
it is made again. Attributes that change but are computed from others are named in `DERIVED`. A test walks over all
objects of a running simulation and finds attributes that are missing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar


class StateMismatch(Exception):
    """A state belongs to another object: one of them has parts that the other lacks."""


@dataclass(frozen=True)
class State:
    """State of an object: name of its class, and its attributes."""

    of: str
    values: dict[str, Any]


class Stateful:
    """Base class of everything that a snapshot must hold.

    Attributes:
        STATE: Names of the attributes that later states depend on.
        DERIVED: Names of attributes that change, too, but follow from the others.
    """

    STATE: ClassVar[tuple[str, ...]] = ()
    DERIVED: ClassVar[tuple[str, ...]] = ()

    def save(self) -> State:
        """Return the state. It shares objects with the running simulation; encode it before anything changes."""
        present = vars(self)
        return State(type(self).__name__, {name: _saved(present[name]) for name in self.STATE if name in present})

    def restore(self, state: State) -> None:
        """Restore a state of this object or of an equally made one.

        Raises:
            StateMismatch: The state belongs to another kind of object.
        """
        name = type(self).__name__
        if not isinstance(state, State) or state.of != name or not state.values.keys() <= set(self.STATE):
            raise StateMismatch(f"found a {name}; the snapshot has another class")
        present = vars(self)
        for attribute in self.STATE:
            if attribute in state.values:
                present[attribute] = _restored(
                    present.get(attribute), state.values[attribute], f"{name}.{attribute}"
                )
            else:
                present.pop(attribute, None)


def _saved(value: Any) -> Any:
    """Return the saved form of an attribute."""
    match value:
        case Stateful():
            return value.save()
        case dict() if _are_parts(value.values()):
            return {key: part.save() for key, part in value.items()}
        case tuple() | list() if _are_parts(value):
            return [part.save() for part in value]
        case _:
            return value


def _restored(present: Any, saved: Any, where: str) -> Any:
    """Return the restored form of an attribute: parts are restored in place, data are replaced."""
    match present:
        case Stateful():
            present.restore(saved)
        case dict() if _are_parts(present.values()):
            if not isinstance(saved, dict) or saved.keys() != present.keys():
                raise StateMismatch(f"the parts of {where} are not those of the snapshot")
            for key, part in present.items():
                part.restore(saved[key])
        case tuple() | list() if _are_parts(present):
            if not isinstance(saved, list) or len(saved) != len(present):
                raise StateMismatch(f"the parts of {where} are not those of the snapshot")
            for part, one in zip(present, saved, strict=True):
                part.restore(one)
        case _ if _has_states(saved):
            raise StateMismatch(f"the snapshot has parts of {where} that are missing here")
        case _:
            return saved
    return present


def _are_parts(values: Any) -> bool:
    return any(isinstance(value, Stateful) for value in values)


def _has_states(saved: Any) -> bool:
    """Whether the values are states of parts rather than data."""
    match saved:
        case State():
            return True
        case dict():
            return any(isinstance(value, State) for value in saved.values())
        case list():
            return any(isinstance(value, State) for value in saved)
        case _:
            return False
