"""Dataclasses that are completed for their first instance behave as those of the standard library."""

from __future__ import annotations

import dataclasses
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import KW_ONLY, FrozenInstanceError, field, fields, is_dataclass, replace
from functools import cached_property
from inspect import signature
from threading import Barrier
from typing import Any, Generic, TypeVar

import pytest

from seoro.deferred import dataclass

T = TypeVar("T")


@dataclass(frozen=True)
class Point:
    x: float
    y: float = 0.0


@dataclass(frozen=True)
class Named(Point):
    name: str = ""
    tags: list[str] = field(default_factory=list, compare=False)

    @cached_property
    def title(self) -> str:
        return self.name.title()


def is_complete(cls: type) -> bool:
    return "__match_args__" in vars(cls)


def new_class(**options: Any) -> Any:
    @dataclass(**options)
    class Pair:
        first: int
        second: int = 2

    return Pair


def test_a_class_is_completed_for_its_first_instance() -> None:
    pair = new_class(frozen=True)
    assert not is_complete(pair)
    assert pair(1) == pair(first=1, second=2) != pair(1, 3)
    assert is_complete(pair)
    assert repr(pair(1)).endswith("Pair(first=1, second=2)")
    assert hash(pair(1)) == hash(pair(1, 2))
    with pytest.raises(FrozenInstanceError):
        pair(1).first = 2
    with pytest.raises(FrozenInstanceError):
        pair(1).other = 2
    with pytest.raises(TypeError, match="first"):
        pair()


def test_the_signature_of_a_class_is_known_before_its_first_instance() -> None:
    pair = new_class(frozen=True)

    class Heir(new_class()):  # type: ignore[misc]
        pass

    for each in (pair, Heir):
        found = signature(each, eval_str=True).parameters
        assert {name: one.annotation for name, one in found.items()} == {"first": int, "second": int}
        assert found["second"].default == 2


def test_functions_of_dataclasses_complete_a_class() -> None:
    for ask in (fields, is_dataclass):
        pair: Any = new_class()
        assert ask(pair)
        assert is_complete(pair)
    assert [each.name for each in fields(new_class())] == ["first", "second"]
    assert replace(Named(1.0, name="a"), y=2.0) == Named(1.0, 2.0, "a")


def test_classes_inherit_fields_also_as_plain_dataclasses_and_plain_classes() -> None:
    @dataclass(frozen=True)
    class Base:
        x: int

    @dataclass(frozen=True)
    class Heir(Base):
        y: int = 1

    @dataclasses.dataclass(frozen=True)
    class Plain(Base):
        z: int = 2

    class Other(Heir):
        pass

    assert Other(3) == Other(3, 1)
    assert (Heir(3).x, Heir(3).y) == (3, 1)
    assert Plain(3) == Plain(3, 2)
    assert Named(1.0, name="ab").title == "Ab"
    assert Named(1.0).tags is not Named(1.0).tags


def test_equality_by_identity_changeable_fields_and_keywords() -> None:
    same = new_class(eq=False)
    assert same(1) != same(1)
    changed = new_class()(1)
    changed.first = 5
    assert changed.first == 5

    @dataclass(frozen=True, eq=False)
    class Generically(Generic[T]):
        value: T
        _: KW_ONLY
        limit: int = 0

        def __post_init__(self) -> None:
            if self.limit < 0:
                raise ValueError("limit")

    assert Generically("a", limit=1).limit == 1
    with pytest.raises(TypeError):
        Generically("a", 1)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="limit"):
        Generically(1, limit=-1)


def test_patterns_match_its_fields() -> None:
    match Point(1.0, 2.0):
        case Point(x, y):
            assert (x, y) == (1.0, 2.0)
        case _:
            pytest.fail("no match")


def test_first_instances_from_many_threads_are_complete() -> None:
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            for _ in range(20):
                barrier, cls = Barrier(4), new_class(frozen=True)

                def make(number: int, barrier: Barrier = barrier, cls: Any = cls) -> Any:
                    barrier.wait()
                    return cls(number)

                assert [each.first for each in pool.map(make, range(4))] == [0, 1, 2, 3]
    finally:
        sys.setswitchinterval(interval)


def test_defaults_of_fields_are_attributes_of_the_class() -> None:
    @dataclass(frozen=True)
    class Fault:
        kind: str = field(default="bias", kw_only=True)
        amount: float

    assert Fault.kind == "bias"
    assert (Fault(1.0).kind, Fault(1.0, kind="noise").kind) == ("bias", "noise")
