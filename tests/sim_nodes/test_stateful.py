from __future__ import annotations

import pytest

from sim_nodes.codec import pack, unpack
from sim_nodes.stateful import State, Stateful, StateMismatch


class Part(Stateful):
    STATE = ("count",)

    def __init__(self) -> None:
        self.count = 0


class Whole(Stateful):
    STATE = ("part", "named", "row", "last", "late")

    def __init__(self, parts: int = 2) -> None:
        self.part = Part()
        self.named = {str(index): Part() for index in range(parts)}
        self.row = [Part() for _ in range(parts)]
        self.last: list[int] | None = None


def changed() -> Whole:
    whole = Whole()
    whole.part.count, whole.named["1"].count, whole.row[0].count = 1, 2, 3
    whole.last = [4]
    return whole


def saved(whole: Whole) -> State:
    state = unpack(pack(whole.save()))
    assert isinstance(state, State)
    return state


def test_restoring_keeps_parts_and_replaces_values() -> None:
    other = Whole()
    part, named, row = other.part, other.named["1"], other.row[0]
    other.restore(saved(changed()))
    assert (other.part, other.named["1"], other.row[0]) == (part, named, row)
    assert (part.count, named.count, row.count, other.last) == (1, 2, 3, [4])


def test_restoring_removes_attributes_missing_in_the_state() -> None:
    state = saved(Whole())
    whole = Whole()
    vars(whole)["late"] = 1
    whole.restore(state)
    assert not hasattr(whole, "late")
    vars(whole)["late"] = 1
    other = Whole()
    other.restore(saved(whole))
    assert vars(other)["late"] == 1


@pytest.mark.parametrize(
    ("state", "words"),
    [
        (State("Part", {}), "found a Whole"),
        (State("Whole", {"unknown": 1}), "found a Whole"),
        (saved(Whole(3)), "the parts of Whole.named"),
        (State("Whole", {"row": []}), "the parts of Whole.row"),
        (State("Whole", {"part": None}), "found a Part"),
        (State("Whole", {"last": [State("Part", {})]}), "parts of Whole.last that are missing here"),
        (State("Whole", {"last": State("Part", {})}), "parts of Whole.last that are missing here"),
    ],
    ids=repr,
)
def test_states_of_another_class_are_refused(state: State, words: str) -> None:
    with pytest.raises(StateMismatch, match=words):
        Whole().restore(state)
