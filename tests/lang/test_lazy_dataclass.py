"""Dataclasses that are created with their first instance."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import field, fields, is_dataclass, replace
from threading import Barrier
from typing import Any

import pytest

from seoro.lang.lazy_dataclass import lazy_dataclass


@lazy_dataclass
class Base:
    a: int
    b: list[int] = field(default_factory=list)


@lazy_dataclass
class Derived(Base):
    c: str = "c"

    def __post_init__(self) -> None:
        self.c += "!"


def test_a_class_is_a_dataclass_once_it_has_an_instance() -> None:
    assert not is_dataclass(Derived)
    made = Derived(1, c="x")
    assert is_dataclass(Derived)
    assert [each.name for each in fields(made)] == ["a", "b", "c"]
    assert (made.a, made.b, made.c) == (1, [], "x!")
    assert repr(Base(2, [3])) == "Base(a=2, b=[3])"
    assert replace(made, a=5).a == 5


def test_instances_are_equal_only_to_themselves() -> None:
    assert Base(1) != Base(1)
    assert len({Base(1), Base(1)}) == 2


def test_wrong_arguments_are_refused_by_each_instance() -> None:
    @lazy_dataclass
    class Small:
        a: int

    for _ in range(2):
        with pytest.raises(TypeError):
            Small()  # type: ignore[call-arg]


def test_instances_have_their_own_defaults() -> None:
    assert Base(1).b is not Base(1).b


def test_first_instances_from_many_threads_are_complete() -> None:
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            for _ in range(20):

                @lazy_dataclass
                class Pair:
                    first: int
                    second: list[int] = field(default_factory=list)

                barrier = Barrier(4)

                def make(number: int, barrier: Barrier = barrier, cls: Any = Pair) -> Any:
                    barrier.wait()
                    return cls(number)

                found = list(pool.map(make, range(4)))
                assert [(each.first, each.second) for each in found] == [(0, []), (1, []), (2, []), (3, [])]
    finally:
        sys.setswitchinterval(interval)
