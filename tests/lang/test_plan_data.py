"""Plans as JSON text: decoding gives the same plan with the same shared nodes, and rejects everything else."""

from __future__ import annotations

import json
import math
import pkgutil
from enum import Enum
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seoro.embed import load
from seoro.errors import InvalidScenario
from seoro.lang import plan, plan_data
from seoro.lang.arithmetic import Number
from seoro.lang.frozen import Frozen, Value
from seoro.lang.plan import (
    EnumValue,
    ListType,
    Literal,
    Method,
    Methods,
    Overlap,
    PrimitiveType,
    StructType,
    Structure,
    Structures,
    Undefined,
    ValueType,
)
from seoro.lang.plan_data import PlanDataError, decode, encode
from seoro.lang.source import SourceFile, Span
from tests.generated.model import Program
from tests.generated.running import load_text
from tests.generated.strategies import programs
from tests.plan_outline import outline
from tests.sampling import sampled

ROOT = Path(__file__).parents[2]
FILES = (SourceFile("a.osc", "one"), SourceFile("b.osc", "twenty two"))
SPAN = Span(FILES[1], 2, 5)
QUICK = settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
LONG = settings(QUICK, max_examples=2000)


def copied(value: Any) -> Any:
    """Encode and decode a value."""
    return decode(encode(value, FILES), FILES)


RUNNABLE = sorted(path for part in ("scenarios", "examples") for path in (ROOT / part).rglob("*.osc"))


@pytest.mark.parametrize("path", sampled(RUNNABLE, every=6), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_plans_of_scenarios_are_decoded_with_their_shared_nodes(path: Path) -> None:
    scenario = load(path)
    for name in scenario.checked.scenarios:
        try:
            made = scenario.plan(name, {})
        except InvalidScenario:  # it has no value for a parameter
            continue
        assert outline(decode(encode(made, scenario.files), scenario.files)) == outline(made)


@QUICK
@given(program=programs())
def test_plans_of_generated_programs_are_decoded_with_their_shared_nodes(program: Program) -> None:
    is_decoded(program)


@pytest.mark.slow
@LONG
@given(program=programs())
def test_plans_of_very_many_programs_are_decoded_with_their_shared_nodes(program: Program) -> None:
    is_decoded(program)


def is_decoded(program: Program) -> None:
    """Check that the decoded plan of a program equals the encoded one."""
    made = load_text(program.text()).plan
    files = tuple({id(node.file): node.file for node in plan_data.nodes(made) if isinstance(node, Span)}.values())
    assert outline(decode(encode(made, files), files)) == outline(made)


VALUES: dict[str, object] = {
    "true and one": (True, 1, 1.0, False, 0, 0.0),
    "negative zero": (-0.0,),
    "infinite": (math.inf, -math.inf),
    "large and small floats": (1e300, 5e-324, 0.1, 1e22),
    "integers": (-1, 2**63, -(2**2000)),
    "text": ("", '[{\n\0"é\ud800😀', "inf"),
    "none": (None,),
    "nested": ((), ((),), frozenset(), frozenset({"a", "b"}), {}),
    "keys": {("a", "b"): 1, 2: "c", None: 3, Overlap.FULL: 4, 1.5: 5},
    "enumerations": (Overlap.EQUAL, EnumValue("kind", "a", 3), (Overlap.EQUAL,)),
    "span": (SPAN, SPAN, Span(FILES[0], 0, 3)),
    "literal": Literal(2**70, SPAN),
}


@pytest.mark.parametrize("name", VALUES)
def test_values_are_decoded(name: str) -> None:
    assert outline(copied(VALUES[name])) == outline(VALUES[name])


def test_nan_is_decoded() -> None:
    (found,) = copied((math.nan,))
    assert math.isnan(found)


def test_equal_nodes_are_decoded_separately_and_shared_nodes_once() -> None:
    node, equal = PrimitiveType("int"), PrimitiveType("int")
    first, second, third = copied((node, node, equal))
    assert first is second
    assert first is not third
    assert first == third == node


def test_dicts_and_sets_are_encoded_independently_of_their_order() -> None:
    words = [f"word {number}" for number in range(100)]
    assert encode(frozenset(words), ()) == encode(frozenset(reversed(words)), ())


def test_methods_are_decoded_without_their_functions() -> None:
    methods = Methods()
    external = plan.External("os.abort", (), (), (), SPAN)
    methods.add("t", "m", Method("m", (("p", None),), None, external, SPAN))
    methods.bind(external, lambda *_: None)
    found = copied(methods)
    assert outline(found) == outline(methods)
    ((_, same),) = found.externals()
    assert same == external
    assert found.function(same) is None


def test_structures_are_decoded_by_the_names_of_their_types() -> None:
    structures = Structures()
    for name in ("b", "a"):
        structures.add(Structure(StructType(name, (), ()), {}, (), (), frozenset(), SPAN))
    assert [each.type.name for each in copied(structures).all()] == ["b", "a"]


def test_deep_plans_are_encoded_and_decoded_without_recursion() -> None:
    deep: ValueType = PrimitiveType("int")
    for _ in range(100_000):
        deep = ListType(deep)
    found, levels = copied(deep), 0
    while isinstance(found, ListType):
        found, levels = found.element, levels + 1
    assert (found, levels) == (PrimitiveType("int"), 100_000)


def test_every_class_of_plans_has_a_number() -> None:
    modules = [import_module(f"seoro.lang.plan.{each.name}") for each in pkgutil.iter_modules(plan.__path__)]
    defined = {
        found
        for module in modules
        for found in vars(module).values()
        if isinstance(found, type) and issubclass(found, Frozen | Enum) and found.__module__ == module.__name__
    }
    assert {Number, *defined} == set(plan_data._CLASSES.values())
    assert all("__init__" not in vars(cls) or issubclass(cls, Frozen) for cls in defined)


class _Unknown(Value):
    a: int


class _Text(str):
    __slots__ = ()


def _cycle() -> dict[str, object]:
    found: dict[str, object] = {}
    found["again"] = (found,)
    return found


UNSUPPORTED: dict[str, object] = {
    "another class": (_Unknown(1),),
    "a list": ([],),
    "a set": {1},
    "a function": print,
    "a subclass of str": _Text("a"),
    "a subclass of dict": MappingProxyType({}),
    "a file": FILES[0],
    "a path": Path(),
    "a span of another file": Span(SourceFile("a.osc", "one"), 0, 1),
    "a node as a key": {PrimitiveType("int"): 1},
    "a node in a set": frozenset({PrimitiveType("int")}),
    "an integer of many digits": 10**5000,
    "a cycle": _cycle(),
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_other_values_are_not_encoded(name: str) -> None:
    with pytest.raises(PlanDataError):
        encode(UNSUPPORTED[name], FILES)


def number_of(cls: type) -> int:
    return plan_data._NUMBERS[cls]


INT, FLOAT, TUPLE, FROZENSET, DICT, SPANS, STRUCTURES, METHODS = range(8)
NAME = [number_of(PrimitiveType), "int"]
INVALID: dict[str, object] = {
    "no list": {},
    "no nodes": [],
    "text": "plan",
    "a node of another type": [1],
    "an empty node": [[]],
    "a class that is text": [["int"]],
    "a class that is true": [[True, 1]],
    "a class that is a float": [[2.0]],
    "a negative class": [[-1]],
    "an unknown class": [[10_000]],
    "a huge class": [[10**1000]],
    "too few fields": [[number_of(PrimitiveType)]],
    "too many fields": [[*NAME, "b"]],
    "fields with defaults are left out": [[number_of(plan.PhysicalType), "length", "m"]],
    "itself": [[TUPLE, 0]],
    "a later node": [[TUPLE, 1], [TUPLE]],
    "a node before the first": [[TUPLE], [TUPLE, -1]],
    "a list as a field": [[TUPLE, []]],
    "a dict as a field": [[TUPLE, {}]],
    "no integer": [[INT]],
    "an integer that is true": [[INT, True]],
    "an integer that is text": [[INT, "1"]],
    "a float that is text": [[FLOAT, "1.0"]],
    "a float of a list": [[FLOAT, ["inf"]]],
    "a span of a missing file": [[SPANS, 2, 0, 0]],
    "a span of a file before the first": [[SPANS, -1, 0, 0]],
    "a span beyond its file": [[SPANS, 0, 0, 4]],
    "a span backwards": [[SPANS, 0, 2, 1]],
    "a span of text": [[SPANS, 0, "a", "b"]],
    "a span without an end": [[SPANS, 0, 1]],
    "an unknown member": [[number_of(Overlap), "EVERY"]],
    "an attribute of an enumeration": [[number_of(Overlap), "__class__"]],
    "a member of a node": [[TUPLE], [number_of(Overlap), 0]],
    "a key without a value": [[DICT, "a"]],
    "a node as a key": [NAME, [DICT, 0, "a"]],
    "a dict as a key": [[DICT], [DICT, 0, "a"]],
    "a nested key": [[TUPLE], [TUPLE, 0], [DICT, 1, "a"]],
    "a node in a set": [NAME, [FROZENSET, 0]],
    "structures of other classes": [NAME, [STRUCTURES, 0]],
    "methods of other classes": [NAME, [METHODS, "a", "b", 0]],
    "a method without a name": [NAME, [METHODS, "a"]],
    "a method with a node as its name": [NAME, [METHODS, 0, "b", 0]],
}


@pytest.mark.parametrize("name", INVALID)
def test_invalid_data_are_rejected(name: str) -> None:
    with pytest.raises(PlanDataError):
        decode(json.dumps(INVALID[name]), FILES)


@pytest.mark.parametrize("text", ["", "[", "[[2]", "nan", "[" * 100_000, '{"a":' * 100_000, f"[[0,{'9' * 5000}]]"])
def test_text_that_is_not_json_is_rejected(text: str) -> None:
    with pytest.raises(PlanDataError):
        decode(text, FILES)


def test_a_structure_with_an_unhashable_name_is_rejected() -> None:
    type_ = [number_of(StructType), 0, 0, 0]
    structure = [number_of(Structure), 1, 0, 0, 0, 0, 0, False]
    with pytest.raises(PlanDataError):
        decode(json.dumps([[DICT], type_, structure, [STRUCTURES, 2]]), FILES)


SAMPLE = json.loads(
    encode(
        (
            Literal(1.5, SPAN),
            {("a", "b"): Overlap.FULL},
            frozenset({"a"}),
            Method("m", (("p", None),), PrimitiveType("int"), Undefined(SPAN), SPAN),
            math.inf,
            12,
        ),
        FILES,
    )
)
_JUNK = st.one_of(
    st.integers(-3, 120), st.sampled_from([None, True, 1.5, "a", [], {}, [2, [3]], {"a": 1}, 10**30, "__class__"])
)


@QUICK
@given(changes=st.lists(st.tuples(st.integers(0, 100), st.integers(0, 10), _JUNK), min_size=1, max_size=4))
def test_changed_data_are_decoded_or_rejected(changes: list[tuple[int, int, object]]) -> None:
    table = json.loads(json.dumps(SAMPLE))
    for row, column, junk in changes:
        node = table[row % len(table)]
        if isinstance(node, list) and node and column < 9:
            node[column % len(node)] = junk
        else:
            table[row % len(table)] = junk
    try:
        decoded = decode(json.dumps(table), FILES)
    except PlanDataError:
        return
    assert decoded is None or type(decoded).__module__.startswith(("builtins", "seoro.lang"))
