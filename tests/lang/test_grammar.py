"""The parse table and the builder match the grammar."""

from __future__ import annotations

import json

from seoro.lang import grammar, parse_table
from seoro.lang.build import Builder, callback_of


def test_the_parse_table_equals_that_of_the_grammar() -> None:
    generated = json.loads(json.dumps(grammar.generate()))
    assert generated == parse_table.load(), "run `python -m seoro.lang.grammar`"


def test_every_production_with_a_node_has_a_callback() -> None:
    made = {callback for _, _, pick, kind, callback in parse_table.load()["rules"] if kind == "node"}
    made |= {rule[4] for rule in parse_table.load()["rules"] if rule[3] == "only" and len(rule[2]) > 1}
    assert all(callable(callback_of(production)) for production in made)
    methods = {name for name in dir(Builder) if not name.startswith("_")}
    assert methods <= made
