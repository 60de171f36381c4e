"""Parser: keywords as names, precedence, recovery, and random texts."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.lang import ast, parse_table
from seoro.lang.diagnostic import Bag
from seoro.lang.parser import parse_expression, parse_file
from seoro.lang.source import SourceFile, Span
from tests.lang.helpers import expression, parse

KEYWORDS = sorted(word for word in parse_table.load()["literals"] if word[0].isalpha())
VALUES = {"true", "false", "it", "inf", "nan", "not"}  # they mean something wherever an expression may stand
BLOCKS = {"with", "serial", "parallel", "one_of"}  # followed by a colon, they begin a block


@pytest.mark.parametrize("word", [word for word in KEYWORDS if word not in VALUES | BLOCKS])
def test_a_keyword_can_be_the_name_of_a_field(word: str) -> None:
    tree, codes = parse(f"scenario main:\n    {word}: int = 1\n    x, {word}: int\n    do emit end\n")
    assert codes == []
    (scenario,) = tree.statements
    assert isinstance(scenario, ast.ScenarioDeclaration)
    assert isinstance(scenario.members[0], ast.ParameterDeclaration)
    assert scenario.members[0].names[0].text == word


@pytest.mark.parametrize("word", [word for word in KEYWORDS if word not in VALUES])
def test_a_keyword_can_be_read_as_a_name(word: str) -> None:
    tree, codes = parse(f"struct a:\n    x: int = {word} + b.{word} * (2 - {word})\n    y: a = f({word}: 1)\n")
    assert codes == []
    assert len(tree.statements) == 1


def test_directives_and_fields_are_distinguished() -> None:
    text = "scenario a:\n    do: int\n    event: int\n    wait: time\n    event event\n    do do: wait wait > 3\n"
    tree, codes = parse(text)
    assert codes == []
    (scenario,) = tree.statements
    assert isinstance(scenario, ast.ScenarioDeclaration)
    assert [type(member).__name__ for member in scenario.members] == [
        *["ParameterDeclaration"] * 3,
        "EventDeclaration",
        "DoDirective",
    ]


def test_a_range_constructor_and_a_field_named_range_are_distinguished() -> None:
    assert isinstance(expression("range(1, 2)"), ast.RangeConstructor)
    assert isinstance(expression("range * 2"), ast.Arithmetic)


@pytest.mark.parametrize(
    "text", ["5", "0x1F", "0.25", "1e-3", "2.5mps", "3x::s", "1|km|", "18446744073709551616", "1e999"]
)
def test_a_lone_number_is_read_as_in_a_longer_expression(text: str) -> None:
    alone, longer = (SourceFile("<number>", whole) for whole in (f"a={text}", f"a={text} + b"))
    bags = Bag(), Bag()
    tree, summed = parse_expression(alone, bags[0], 2), parse_expression(longer, bags[1], 2)
    assert [each.code for each in bags[0].diagnostics] == [each.code for each in bags[1].diagnostics]
    assert (tree is None) is (summed is None)
    if tree is not None:
        assert isinstance(summed, ast.Arithmetic)
        assert repr(tree) == repr(summed.left)
        assert (tree.span.start, tree.span.text) == (2, text)


def test_operators_have_the_precedence_of_the_standard() -> None:
    tree = expression("not a == 1 + 2 * -b and c or d => e ? f : g ? h : i")
    assert isinstance(tree, ast.TernaryOpExp)
    assert isinstance(tree.otherwise, ast.TernaryOpExp)
    implication = tree.condition
    assert isinstance(implication, ast.Logic) and implication.operator == "=>"
    disjunction = implication.left
    assert isinstance(disjunction, ast.Logic) and disjunction.operator == "or"
    conjunction = disjunction.left
    assert isinstance(conjunction, ast.Logic) and conjunction.operator == "and"
    assert isinstance(conjunction.left, ast.Inversion)
    assert isinstance(conjunction.left.operand, ast.Relation)


def test_postfix_operators_follow_one_another() -> None:
    tree = expression("a.b[1].as(list of c).d(x, y: 2).is(int)")
    assert isinstance(tree, ast.TypeTestExp)
    assert isinstance(tree.base, ast.FunctionApplication)
    assert [argument.name.text for argument in tree.base.arguments.named] == ["y"]


def test_a_name_before_a_colon_in_a_ternary_is_not_an_argument() -> None:
    tree = expression("f(a ? b : c, d: e ? true : it)")
    assert isinstance(tree, ast.FunctionApplication)
    assert len(tree.arguments.positional) == 1


def test_spans_cover_the_text_of_expressions() -> None:
    tree = expression("(a + 1) * f(b)")
    assert tree.span.text == "(a + 1) * f(b)"
    assert isinstance(tree, ast.Arithmetic)
    assert tree.left.span.text == "a + 1"
    assert tree.right.span.text == "f(b)"


def test_long_chains_and_lists_are_parsed_without_recursion() -> None:
    assert isinstance(expression(" + ".join(["1"] * 5000)), ast.Arithmetic)
    tree = expression("[" + ", ".join(["1"] * 5000) + "]")
    assert isinstance(tree, ast.ListConstructor)
    assert len(tree.items) == 5000


def test_one_run_reports_the_errors_of_all_statements() -> None:
    struct = "struct a:\n    x int\n    y: int\n    z: = 3\n"
    scenario = "scenario b\n    do serial:\n        wait elapsed(\nenum c: [\n"
    _, codes = parse(struct + scenario)
    assert len(codes) == 5


def test_statements_around_an_error_are_parsed() -> None:
    tree, codes = parse("struct a:\n    x int\n    y: int\nstruct b\n")
    assert len(codes) == 1
    first = tree.statements[0]
    assert isinstance(first, ast.StructDeclaration)
    assert isinstance(first.members[0], ast.InvalidStatement)
    assert isinstance(first.members[1], ast.ParameterDeclaration)


@dataclass(frozen=True)
class Parsed:
    text: str
    bag: Bag
    tree: ast.OscFile


def run(text: str) -> Parsed:
    bag = Bag()
    return Parsed(text, bag, parse_file(SourceFile("test.osc", text), bag))


def assert_spans_lie_within(node: object, length: int) -> None:
    stack = [node]
    while stack:
        current = stack.pop()
        if isinstance(current, Span):
            assert 0 <= current.start <= current.end <= length
        elif isinstance(current, tuple):
            stack += current
        elif hasattr(current, "__match_args__") and not isinstance(current, SourceFile):
            stack += [getattr(current, name) for name in current.__match_args__]


WORDS = [
    *parse_table.load()["literals"],
    "x",
    "3m",
    "1.5",
    "\n",
    "\n    ",
    "\n        ",
    "\n\t",
    '"s"',
    "# c",
    "\\\n",
    "|",
    "'",
]


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.text(max_size=200), st.lists(st.sampled_from(WORDS), max_size=60).map(" ".join)))
def test_no_text_breaks_the_parser(text: str) -> None:
    parsed = run(text)
    assert_spans_lie_within(parsed.tree, len(text))
    for found in parsed.bag.diagnostics:
        assert 0 <= found.primary.span.start <= found.primary.span.end <= len(text)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from([word for word in WORDS if "\n" not in word]), max_size=12).map(" ".join))
def test_no_text_breaks_the_parser_of_expressions(text: str) -> None:
    bag = Bag()
    tree = parse_expression(SourceFile("test", text), bag)
    assert (tree is None) == (len(bag) > 0)
