"""The parse table belongs to the grammar, and the builder to both."""

from __future__ import annotations

import json

from seoro.lang import grammar, table
from seoro.lang.build import Builder


def test_the_table_is_that_of_the_grammar() -> None:
    generated = json.loads(json.dumps(grammar.generate()))
    assert generated == table.load(), "run `python -m seoro.lang.grammar`"


def test_every_production_with_a_node_has_a_method() -> None:
    made = {callback for _, _, pick, kind, callback in table.load()["rules"] if kind == "node"}
    made |= {rule[4] for rule in table.load()["rules"] if rule[3] == "only" and len(rule[2]) > 1}
    methods = {name for name in dir(Builder) if not name.startswith("_")}
    assert made == methods
