"""Completion at the cursor.

The text is unfinished there, so its tokens determine the place (`cursor.py`, `regions.py`), and the last check the
meaning of names (`cursor_context.py`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from lsprotocol.types import CompletionItemKind as Sort

from seoro.lang import ast, plan
from seoro.lang.symbols import (
    Enumeration,
    EnumSymbol,
    FieldSymbol,
    Kind,
    QuantitySymbol,
    Structured,
    Type,
    TypeSymbol,
)
from seoro.lang.types import PRIMITIVES, is_known, quantity
from seoro.lsp import items
from seoro.lsp.analysis import Analysis
from seoro.lsp.cursor import Cursor, read_cursor
from seoro.lsp.cursor_context import CursorContext, callee, cursor_context
from seoro.lsp.describe import parameters_of
from seoro.lsp.items import Item
from seoro.lsp.regions import COMPOSITIONS, KEYWORDS, TYPES, Region, behavior_start, region

_COMPARISONS = frozenset({"==", "!=", "<", "<=", ">", ">=", "in"})
_EVENT_WORDS = frozenset({"wait", "until", "on", "if"})
_EVENT_FORMS = ("elapsed", "every", "rise", "fall")
_BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset")


@dataclass(frozen=True)
class Completion:
    """Completion items, and the start of the text that they replace."""

    start: int
    items: tuple[Item, ...]


def complete(text: str, offset: int, analyses: Sequence[Analysis]) -> Completion:
    """Complete the text at the cursor.

    Args:
        text: Current text.
        offset: Offset of the cursor.
        analyses: Analyses of the document, newest first; at least one.
    """
    cursor = read_cursor(text, offset)
    if cursor is None:
        return Completion(offset, ())
    words = cursor.line.words
    if words[0] == "import" and len(words) > 1:
        start = cursor.line.tokens[1].start
        return Completion(start, tuple(items.modules(cursor.file.text[start : cursor.start], cursor.file.path)))
    around = cursor_context(cursor, analyses)
    found = {(item.label, item.sort): item for item in reversed(list(_items(around)))}
    return Completion(cursor.start, tuple(found.values()))


def _items(around: CursorContext) -> Iterable[Item]:
    cursor = around.cursor
    words = cursor.line.words
    place = len(words) - 1
    before = words[place - 1] if place else ""
    if cursor.number is not None:
        return items.units(around.program, _expected(around))
    if before == ".":
        return _members(around, place - 1)
    if before == "!":
        enum = around.find_type(cursor.text(place - 2, place - 1))
        return items.enum_members(enum) if isinstance(enum, EnumSymbol) else ()
    if before == "@":
        return _events(around)
    if cursor.brackets:
        return _in_bracket(around)
    match region(cursor):
        case Region.FILE:
            return _in_header(around)
        case Region.MEMBERS:
            return _in_member(around)
        case Region.BEHAVIORS:
            return _in_behavior(around, behavior_start(cursor) or 0)
        case Region.WITH:
            return _in_with(around)
        case Region.ON:
            return items.keywords(KEYWORDS[Region.ON]) if place == 0 else _emitted(around)


# ---------------------------------------------------------------- after a dot and `@`


def _members(around: CursorContext, dot: int) -> Iterable[Item]:
    """Complete after a dot."""
    cursor = around.cursor
    words = cursor.line.words
    first = cursor.receiver(dot)
    base = cursor.text(first, dot)
    before = words[first - 1] if first else ""
    if before == "@":
        return _events_of(around, base)
    if words[0] in TYPES and region(cursor) is Region.FILE and not cursor.brackets:
        symbol = around.find_type(base)
        is_actor = isinstance(symbol, TypeSymbol) and before in {"extend", "inherits", "of"}
        return items.behaviors(around, symbol) if is_actor and isinstance(symbol, TypeSymbol) else ()
    type_ = around.type_of(base)
    if first == behavior_start(cursor) and not cursor.brackets and isinstance(type_, Structured):
        return _invocable(around, type_.symbol)
    struct = around.find_type(base)
    if not is_known(type_) and isinstance(struct, TypeSymbol) and struct.kind is Kind.STRUCT:
        type_ = Structured(struct)  # methods may be called on the default value of a struct
    return items.members(type_, around.program)


def _invocable(around: CursorContext, owner: TypeSymbol) -> Iterable[Item]:
    """Yield the behaviors of an object, and its fields that hold objects."""
    here = region(around.cursor)
    if here is Region.BEHAVIORS or around.cursor.line.words[0] == "do":
        yield from items.behaviors(around, owner)
        for found in owner.inventory.fields.values():
            if isinstance(found.type, Structured):
                yield items.field(found, around.program)
    else:
        yield from items.modifiers(around, owner)


def _events(around: CursorContext) -> Iterable[Item]:
    """Complete after `@`."""
    yield from items.events(around, around.owner)
    yield from (Item(label, Sort.Reference, "label", rank=items.FIRST) for label in around.labels)
    for found in around.scope.fields.values():
        if isinstance(found.type, Structured):
            yield items.field(found, around.program)


def _events_of(around: CursorContext, base: str) -> Iterable[Item]:
    """Yield the events of a labelled behavior, or of an object."""
    member = around.labels.get(base)
    if member is None:
        type_ = around.type_of(base)
        return items.events(around, type_.symbol if isinstance(type_, Structured) else None)
    if isinstance(member.body, ast.BehaviorInvocation):
        function = member.body.invocation.function
        actor: TypeSymbol | None = None
        if isinstance(function, ast.FieldAccess):
            type_ = around.type_of(function.base.span.text)
            actor = type_.symbol if isinstance(type_, Structured) else None
        if isinstance(function, ast.FieldAccess | ast.NameExpression):
            return items.events(around, around.find_behavior(function.name.text, actor))
    return items.phases()


# ---------------------------------------------------------------- statements


def _in_header(around: CursorContext) -> Iterable[Item]:
    """Complete the line of a declaration."""
    words = around.cursor.line.words
    place, before = len(words) - 1, words[-2] if len(words) > 1 else ""
    match words[0], before:
        case _, "" if place == 0:
            return items.keywords(KEYWORDS[Region.FILE])
        case (("scenario" | "action"), "inherits"):
            return _all_behaviors(around)
        case ("struct" | "actor") as kind, "inherits":
            return items.types(around, (Kind(kind),))
        case "extend", "extend":
            return (*items.types(around), *items.behaviors(around, None))
        case "unit", "of":
            return items.physical_types(around)
        case "modifier", "of":
            return _all_behaviors(around)
        case (("scenario" | "action" | "modifier"), _) if place == 1:
            return items.types(around, (Kind.ACTOR,))
        case "global", _ if place > 1:
            return _after_name(around)
        case (("struct" | "actor" | "scenario" | "action"), _) if place == 2:
            return items.keywords(("inherits",))
        case _:
            return ()


def _all_behaviors(around: CursorContext) -> Iterable[Item]:
    return (*items.behaviors(around, None), *items.types(around, (Kind.ACTOR,)))


def _in_member(around: CursorContext) -> Iterable[Item]:
    """Complete a member of a type."""
    words = around.cursor.line.words
    place = len(words) - 1
    if place == 0:
        return (*items.keywords(KEYWORDS[Region.MEMBERS]), *items.modifiers(around, None))
    match words[0]:
        case "do":
            return _in_behavior(around, behavior_start(around.cursor) or 0)
        case "event":
            return _specification(around) if "is" in words else items.keywords(("is",)) if place > 1 else ()
        case "on":
            return _specification(around)
        case "def":
            return _in_method(around)
        case _:
            return _after_name(around)


def _in_method(around: CursorContext) -> Iterable[Item]:
    """Complete a method, after its name."""
    words = around.cursor.line.words
    if "expression" in words:
        return items.values(around, _expected(around))
    match words[-2]:
        case "->" | "of":
            return items.types(around)
        case "is" | "only":
            return items.keywords(("expression", "undefined", "external", "only"))
        case "def":
            return ()
        case _:
            return items.keywords(("is",))


def _after_name(around: CursorContext) -> Iterable[Item]:
    """Complete the type and the default of a field."""
    words = around.cursor.line.words
    if "=" in words:
        return items.values(around, _expected(around))
    if words[-2] in {":", "of"}:
        return items.types(around)
    return items.keywords(("with",)) if ":" in words else ()


def _in_behavior(around: CursorContext, first: int) -> Iterable[Item]:
    """Complete a line of behaviors, one of which begins at `first`."""
    words = around.cursor.line.words
    place = len(words) - 1
    if place == first:
        return _statements(around)
    match words[first]:
        case "wait":
            return _specification(around)
        case "emit":
            return _emitted(around)
        case word if word in COMPOSITIONS:
            return ()
        case _:
            return items.values(around, None) if place > first else ()


def _statements(around: CursorContext) -> Iterable[Item]:
    """Yield the beginnings of behaviors."""
    yield from items.keywords(KEYWORDS[Region.BEHAVIORS], items.SOON)
    if around.owner is not None and around.owner.actor is not None:
        yield from items.behaviors(around, around.owner.actor)
        yield Item("actor", Sort.Variable, around.owner.actor.name, rank=items.FIRST)
    yield from items.behaviors(around, None)
    for found in (*around.scope.fields.values(), *around.program.globals.values()):
        if isinstance(found.type, Structured):
            yield items.field(found, around.program, items.FIRST)


def _in_with(around: CursorContext) -> Iterable[Item]:
    """Complete a line of a `with:` block."""
    words = around.cursor.line.words
    if len(words) == 1:
        return (*items.keywords(KEYWORDS[Region.WITH]), *items.modifiers(around, None))
    return _specification(around) if words[0] == "until" else items.values(around, None)


def _specification(around: CursorContext) -> Iterable[Item]:
    """Complete an event specification."""
    before = around.cursor.line.words[-2]
    if before in _EVENT_WORDS or before == "is":
        yield Item("@", Sort.Operator, "an event", rank=items.FIRST)
        yield from items.keywords(_EVENT_FORMS, items.FIRST)
    elif "@" in around.cursor.line.words and "if" not in around.cursor.line.words:
        yield from items.keywords(("as", "if"), items.FIRST)
        return
    yield from items.values(around, _expected(around))


def _emitted(around: CursorContext) -> Iterable[Item]:
    """Yield the events that can be emitted."""
    if around.cursor.line.words[-2] != "emit":
        return ()
    phases = (item for item in items.phases() if item.label != plan.Phase.START.value)  # cannot be emitted
    return (*items.declared_events(around, around.owner), *phases)


# ---------------------------------------------------------------- arguments and values


def _in_bracket(around: CursorContext) -> Iterable[Item]:
    """Complete within brackets."""
    cursor = around.cursor
    words, bracket = cursor.line.words, cursor.brackets[-1]
    name = words[bracket.index - 1] if bracket.is_call else ""
    if words[0] in {"event", "def"} and len(cursor.brackets) == 1 and bracket.index == 2:
        return items.types(around) if words[-2] in {":", "of"} else ()
    if name in {"as", "is"} and words[bracket.index - 2] == ".":
        return items.types(around)
    if name == "SI":
        return items.keywords(_BASE_UNITS)
    if name == "keep" and words[-2] == "(":
        return (*items.keywords(("default", "hard")), *items.values(around, None))
    parameters = _open_parameters(around)
    names = items.arguments(parameters, around.program) if words[-2] in {"(", ","} else ()
    return (*names, *items.values(around, _expected(around)))


def _open_parameters(around: CursorContext) -> Iterable[FieldSymbol]:
    """Return the parameters without an argument."""
    given = _arguments_before(around.cursor)
    names = {name for name in given if name}
    positional = sum(not name for name in given[:-1])
    return [parameter for parameter in _parameters(around)[positional:] if parameter.text not in names]


def _parameters(around: CursorContext) -> list[FieldSymbol]:
    """Return the parameters of the innermost call."""
    found = callee(around)
    return list(parameters_of(found).values()) if found is not None else []


def _arguments_before(cursor: Cursor) -> list[str]:
    """Return the names of the arguments in the innermost bracket up to the cursor; empty for positional ones."""
    first = cursor.brackets[-1].index + 1
    names, depth, start = list[str](), 0, first
    words = cursor.line.words
    for index in range(first, len(words) + 1):
        word = words[index] if index < len(words) else ","
        depth += (word in {"(", "["}) - (word in {")", "]"})
        if word == "," and depth == 0:
            names.append(words[start] if words[start + 1 : start + 2] == (":",) else "")
            start = index + 1
    return names


def current_parameter(cursor: Cursor, names: Sequence[str]) -> int | None:
    """Return the number of the parameter whose argument contains the cursor; None without such a parameter."""
    given = _arguments_before(cursor)
    if given[-1]:
        return names.index(given[-1]) if given[-1] in names else None
    return len(given) - 1 if len(given) <= len(names) else None


def _expected(around: CursorContext) -> Type | None:
    """Return the expected type of a value at the cursor; None if any type is valid, or it is unknown."""
    cursor = around.cursor
    words = cursor.line.words
    if len(words) > 2 and words[-2] in _COMPARISONS:
        first = cursor.receiver(len(words) - 2)
        found = around.type_of(cursor.text(first, len(words) - 2))
        return found if is_known(found) else None
    if cursor.brackets:
        return _expected_argument(around)
    if "=" in words and ":" in words and words[-2] == "=":
        return _declared(around, cursor.text(words.index(":") + 1, words.index("=")))
    if "->" in words and words[-2] == "expression":
        return _declared(around, cursor.text(words.index("->") + 1, words.index("is")))
    return None


def _expected_argument(around: CursorContext) -> Type | None:
    """Return the type of the parameter whose argument contains the cursor."""
    name = around.cursor.line.words[around.cursor.brackets[-1].index - 1]
    if name in {"elapsed", "every"}:
        return _declared(around, "time")
    parameters = _parameters(around)
    number = current_parameter(around.cursor, [parameter.text for parameter in parameters])
    return parameters[number].type if number is not None else None


def _declared(around: CursorContext, text: str) -> Type | None:
    """Return the type of a declarator that is a bare name."""
    if text in PRIMITIVES:
        return PRIMITIVES[text]
    match around.find_type(text):
        case EnumSymbol() as symbol:
            return Enumeration(symbol)
        case TypeSymbol() as symbol:
            return Structured(symbol)
        case QuantitySymbol(dimension=dimension):
            return quantity(dimension)
        case None:
            return None
