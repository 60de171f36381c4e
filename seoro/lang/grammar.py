"""Generator of the parse table `osc.json` from the grammar `osc.lark`.

Run `python -m seoro.lang.grammar` after changes of the grammar. A run of a scenario then neither loads lark nor
builds the table, which takes a quarter of a second. A test compares the two files.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.lang.parse_table import SPLICED, TABLE, Table

if TYPE_CHECKING:
    from lark import Lark
    from lark.grammar import Rule

GRAMMAR = Path(__file__).with_name("osc.lark")
STARTS = ("osc_file", "lone_expression")


def digest() -> str:
    """Return the digest of the grammar, which the table contains."""
    return hashlib.sha256(GRAMMAR.read_bytes()).hexdigest()


def generate() -> Table:
    """Build the table from the grammar; raise on conflicts in it."""
    lark = _read_grammar()
    states, starts, ends = _number_states(lark)
    rules = list(lark.rules)
    index = {rule: number for number, rule in enumerate(rules)}
    numbers = {state: number for number, state in enumerate(states)}
    table = lark.parser.parser._parse_table.states
    rows: list[dict[str, int]] = []
    actions: list[int] = []
    gotos: list[dict[str, int]] = []
    shared: dict[str, int] = {}
    terminals = {terminal.name for rule in rules for terminal in rule.expansion if terminal.is_term}
    for state in states:
        row: dict[str, int] = {}
        goto: dict[str, int] = {}
        for symbol, (action, target) in sorted(table[state].items()):
            is_shift = str(action) == "Shift"
            if symbol in terminals or symbol == "$END":
                row[symbol] = numbers[target] if is_shift else -1 - index[target]
            elif not symbol.startswith("$root"):
                goto[symbol] = numbers[target]
        key = json.dumps(row, sort_keys=True)
        if key not in shared:
            shared[key] = len(rows)
            rows.append(row)
        actions.append(shared[key])
        gotos.append(goto)
    assert len(ends) == len(STARTS)
    return Table(
        grammar=digest(),
        literals={terminal.pattern.value: terminal.name for terminal in lark.terminals},
        starts=starts,
        rules=[_describe(rule) for rule in rules],
        rows=rows,
        actions=actions,
        gotos=gotos,
    )


def write() -> None:
    """Write the table beside the grammar."""
    table = generate()
    lines = [f"{json.dumps(key)}: {_layout(value)}" for key, value in table.items()]
    TABLE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _layout(value: object) -> str:
    """Format one item per line, so that diffs show changes of the grammar."""
    if isinstance(value, list) and value and isinstance(value[0], list | dict):
        return "[\n" + ",\n".join(json.dumps(item, separators=(",", ":")) for item in value) + "\n]"
    return json.dumps(value, separators=(",", ":"))


def _read_grammar() -> Lark:
    from lark import Lark  # noqa: PLC0415 - lark is needed for generating only
    from lark.lexer import Lexer  # noqa: PLC0415

    class NoLexer(Lexer):
        """The parser has its own lexer; lark only builds the table."""

        def __init__(self, conf: object) -> None:
            pass

        def lex(self, lexer_state: object, parser_state: object) -> Iterator[Any]:
            raise NotImplementedError

    logging.getLogger("lark").setLevel(logging.ERROR)
    return Lark(GRAMMAR.read_text(encoding="utf-8"), parser="lalr", lexer=NoLexer, start=list(STARTS), strict=True)


def _number_states(lark: Lark) -> tuple[list[Any], dict[str, int], Mapping[str, Any]]:
    """Number the states in the order of traversal, so that the table is deterministic."""
    table = lark.parser.parser._parse_table
    order: dict[Any, None] = {}
    queue = deque(table.start_states[start] for start in STARTS)
    while queue:
        state = queue.popleft()
        if state in order:
            continue
        order[state] = None
        for _, (action, target) in sorted(table.states[state].items()):
            if str(action) == "Shift":
                queue.append(target)
    states = list(order)
    return states, {start: states.index(table.start_states[start]) for start in STARTS}, table.end_states


def _describe(rule: Rule) -> list[Any]:
    """Encode a rule for the table."""
    keep_all = rule.options.keep_all_tokens
    absent = [0] * (len(rule.expansion) + 1)
    if rule.options.empty_indices:
        gaps = "".join(str(int(bit)) for bit in rule.options.empty_indices).split("0")
        absent = [len(gap) for gap in gaps]
    pick: list[int | None] = []
    for number, symbol in enumerate(rule.expansion):
        pick += [None] * absent[number]
        if symbol.is_term:
            if keep_all or not getattr(symbol, "filter_out", False):
                pick.append(number)
        else:
            pick.append(number + SPLICED if symbol.name.startswith("_") else number)
    pick += [None] * absent[-1]
    origin = str(rule.origin.name)
    callback = str(rule.alias or rule.options.template_source or origin)
    kind = "list" if origin.startswith("_") else "only" if rule.options.expand1 and not rule.alias else "node"
    return [origin, len(rule.expansion), pick, kind, callback]


if __name__ == "__main__":
    write()
