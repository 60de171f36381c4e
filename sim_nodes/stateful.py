"""What changes while time passes, and how it is saved and brought back.

A class whose objects change names what has to be kept, and that is all:

    class Thermometer(Stateful):
        STATE = ("_last", "_filter")

Such an attribute is data that `codec` takes, or `Stateful` itself, or a dictionary or a sequence of such parts.
Parts are made with the object that has them, and are restored where they are. What follows from the declaration of
a robot or a world is no state: it is made again. What changes and is computed again when it is missing is named in
`DERIVED`. A test walks over everything that a running simulation consists of, and finds what was forgotten.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar


class StateMismatch(Exception):
    """A state that is not of this object: one of them has parts that the other has not."""


@dataclass(frozen=True)
class State:
    """The state of an object: the name of its class, and its attributes that there were."""

    of: str
    values: dict[str, Any]


class Stateful:
    """Base of everything that a snapshot has to hold.

    Attributes:
        STATE: Names of the attributes that the future follows from.
        DERIVED: Names of attributes that change, too, but follow from the others.
    """

    STATE: ClassVar[tuple[str, ...]] = ()
    DERIVED: ClassVar[tuple[str, ...]] = ()

    def save(self) -> State:
        """What has to be kept. It is encoded before anything changes, and so may refer to what is in use."""
        present = vars(self)
        return State(type(self).__name__, {name: _saved(present[name]) for name in self.STATE if name in present})

    def restore(self, state: State) -> None:
        """Go back to a state that this object had, or one that was made like it.

        Raises:
            StateMismatch: It is not of such an object.
        """
        name = type(self).__name__
        if not isinstance(state, State) or state.of != name or not state.values.keys() <= set(self.STATE):
            raise StateMismatch(f"there is a {name} where the snapshot has something else")
        present = vars(self)
        for attribute in self.STATE:
            if attribute in state.values:
                present[attribute] = _restored(
                    present.get(attribute), state.values[attribute], f"{name}.{attribute}"
                )
            else:
                present.pop(attribute, None)


def _saved(value: Any) -> Any:
    """What is kept of an attribute."""
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
    """What an attribute holds then: its parts stay the objects that they are, data are taken."""
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
            raise StateMismatch(f"the snapshot has parts of {where} that were not made here")
        case _:
            return saved
    return present


def _are_parts(values: Any) -> bool:
    return any(isinstance(value, Stateful) for value in values)


def _has_states(saved: Any) -> bool:
    """Whether these are the states of parts, which are no data."""
    match saved:
        case State():
            return True
        case dict():
            return any(isinstance(value, State) for value in saved.values())
        case list():
            return any(isinstance(value, State) for value in saved)
        case _:
            return False
