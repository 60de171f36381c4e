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

from collections.abc import Collection
from typing import Any, ClassVar

from seoro.deferred import dataclass


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
        case dict() if _contains(value, Stateful):
            return {key: part.save() for key, part in value.items()}
        case tuple() | list() if _contains(value, Stateful):
            return [part.save() for part in value]
        case _:
            return value


def _restored(present: Any, saved: Any, where: str) -> Any:
    """Return the restored form of an attribute: parts are restored in place, data are replaced."""
    if isinstance(present, Stateful):
        present.restore(saved)
    elif _contains(present, Stateful):
        if _keys(saved) != _keys(present):
            raise StateMismatch(f"the parts of {where} are not those of the snapshot")
        for key in _keys(present):
            present[key].restore(saved[key])
    elif isinstance(saved, State) or _contains(saved, State):
        raise StateMismatch(f"the snapshot has parts of {where} that are missing here")
    else:
        return saved
    return present


def _contains(value: Any, kind: type) -> bool:
    """Whether a value is a dictionary or sequence with an object of a class."""
    values = value.values() if isinstance(value, dict) else value if isinstance(value, tuple | list) else ()
    return any(isinstance(each, kind) for each in values)


def _keys(value: Any) -> Collection[Any]:
    """Return the keys of a dictionary or the indices of a sequence; nothing for other values."""
    if isinstance(value, dict):
        return value.keys()
    return range(len(value)) if isinstance(value, tuple | list) else ()
