"""Rewriting of one error; `None` if it needs a decision."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.frozen import Value
from seoro.lang.migration.edits import Edit, Rewriting, indent_of, line_break, line_end, line_start
from seoro.lang.program import Program
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import Kind, QuantitySymbol, TypeSymbol
from seoro.lang.tree import find

INDENT: Final = "    "


def rewriting_of(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Return the rewriting that removes an error of the entry file, or None.

    Args:
        error: The error.
        checked: The checked scenario.
    """
    rule = _RULES.get(error.code)
    return rule(error, checked) if rule is not None else None


# ---------------------------------------------------------------- modifiers among members


def _move_modifiers(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Move the modifiers among the members of a composition into its `with:` block, in their order.

    The first one stays the outermost.
    """
    span = error.primary.span
    file = span.file
    composition = next(_compositions_with(span, checked.sources.entry.tree), None)
    if composition is None:
        return None
    names = {symbol.plan_name for symbol in checked.program.modifiers.values()}
    modifiers = [member for member in composition.members if _called(member) in names]
    others = [member for member in composition.members if member not in modifiers]
    if not others or any(_shares_line(file, member) for member in modifiers):
        return None
    place = _with_place(file, composition, max(others, key=lambda each: each.span.end))
    if place is None:
        return None
    lines = [file.text[each.body.span.start : line_end(file, each.span.end - 1)] for each in modifiers]
    inserted = place.inserted(lines)
    removed = _removed([(line_start(file, each.span.start), each.span.end) for each in modifiers], file)
    joined = next((edit for edit in removed if edit.start == place.offset), None)
    if joined is not None:  # one edit per place
        removed.remove(joined)
        inserted = Edit(place.offset, joined.end, inserted.text)
    listed = ", ".join(f"`{_called(member)}`" for member in modifiers)
    title = f"moved {listed} into the `with:` block of the composition"
    return Rewriting(modifiers[0].span.line, title, (*removed, inserted))


def _compositions_with(span: Span, tree: ast.OscFile) -> Iterator[ast.Composition]:
    """Yield the composition whose member invokes at a place."""
    for composition in find(tree, ast.Composition):
        for member in composition.members:
            body = member.body
            if isinstance(body, ast.BehaviorInvocation) and body.span.start <= span.start < body.span.end:
                yield composition


def _called(member: ast.DoMember) -> str:
    """Return the name of the invoked behavior or modifier; empty for other members."""
    is_call = isinstance(member.body, ast.BehaviorInvocation)
    return member.body.span.text.partition("(")[0].strip() if is_call else ""


def _shares_line(file: SourceFile, member: ast.DoMember) -> bool:
    return bool(file.text[line_start(file, member.span.start) : member.span.start].strip())


class _Place(Value):
    """Place for lines.

    Args:
        offset: Its offset.
        before: Text before each line.
        after: Text after each line.
        head: Text before all lines.
    """

    offset: int
    before: str
    after: str
    head: str = ""

    def inserted(self, lines: Sequence[str]) -> Edit:
        text = self.head + "".join(f"{self.before}{line}{self.after}" for line in lines)
        return Edit(self.offset, self.offset, text)


def _with_place(file: SourceFile, composition: ast.Composition, last: ast.DoMember) -> _Place | None:
    """Return the place for modifiers of a composition; None if its block is on one line."""
    newline = line_break(file)
    block = composition.modifications
    if block is not None:
        first = block.members[0].span.start
        start = line_start(file, first)
        return None if file.text[start:first].strip() else _Place(start, indent_of(file, first), newline)
    indent = indent_of(file, composition.span.start)
    inner = indent_of(file, last.span.start)
    unit = inner.removeprefix(indent) if inner.startswith(indent) and inner != indent else INDENT
    end = line_end(file, _last_code(file.text[: last.span.end]))
    return _Place(end, f"{newline}{indent}{unit}", "", f"{newline}{indent}with:")


def _last_code(text: str) -> int:
    """Return the offset of the last character before trailing comment lines."""
    text = text.rstrip()
    while text.rpartition("\n")[2].lstrip().startswith("#"):
        text = text.rpartition("\n")[0].rstrip()
    return len(text) - 1


def _removed(sections: Sequence[tuple[int, int]], file: SourceFile) -> list[Edit]:
    """Remove whole lines; the last line of a file takes the line break before it along."""
    newline = len(line_break(file))
    edits: list[Edit] = []
    for start, end in sections:
        stop = line_end(file, end - 1)
        is_last = stop == len(file.text)
        first, after = (start, stop) if is_last else (start, stop + newline)
        if edits and edits[-1].end == first:
            first = edits.pop().start
        edits.append(Edit(first - newline if is_last else first, after, ""))
    return edits


# ---------------------------------------------------------------- constructors of actors


def _constrain_actor(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Write the constructor of an actor as constraints of its fields."""
    span = error.primary.span
    file, tree = span.file, checked.sources.entry.tree
    for field in find(tree, ast.ParameterDeclaration):
        call = field.default
        if isinstance(call, ast.FunctionApplication) and call.span.start <= span.start < call.span.end:
            break
    else:
        return None
    actor = _actor(call, checked)
    inside = file.text[call.arguments.span.start : call.arguments.span.end]
    if (
        actor is None
        or field.constraints
        or field.coverage
        or call.span.start > span.start
        or _has_comment(inside)
    ):
        return None
    named = [(argument.name.text, argument.value) for argument in call.arguments.named]
    fields = [each.text for each in actor.inventory.fields.values()]
    if len(call.arguments.positional) > len(fields):
        return None
    values = [*zip(fields, call.arguments.positional, strict=False), *named]
    newline, indent = line_break(file), indent_of(file, field.span.start)
    keeps = "".join(f"{newline}{indent}{INDENT}keep(it.{name} == {value.span.text})" for name, value in values)
    edit = Edit(
        field.type.span.start, call.span.end, f"{call.function.span.text}{' with:' if keeps else ''}{keeps}"
    )
    title = f"wrote the constructor of `{call.function.span.text}` as constraints"
    return Rewriting(span.line, title, (edit,))


def _actor(call: ast.FunctionApplication, checked: Checked) -> TypeSymbol | None:
    name = call.function.span.text
    return next(
        (
            symbol
            for symbol in checked.program.types.values()
            if isinstance(symbol, TypeSymbol) and symbol.kind is Kind.ACTOR and symbol.plan_name == name
        ),
        None,
    )


def _has_comment(text: str) -> bool:
    """Whether a text may have a comment; strings with `#` count, too."""
    return "#" in text


# ---------------------------------------------------------------- values


def _give_unit(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Multiply a number by the SI base unit of the expected physical type."""
    found = _NUMBER_FOR_QUANTITY.match(error.message)
    units = _base_units(found[1], checked.program) if found is not None else []
    if not units:
        return None
    span, unit = error.primary.span, min(units, key=len)
    text = span.text if re.fullmatch(r"[\w.]+(\([^()]*\)[\w.]*)?", span.text) else f"({span.text})"
    return Rewriting(span.line, f"gave `{span.text}` a unit", (Edit(span.start, span.end, f"{text} * 1{unit}"),))


def _base_units(quantity: str, program: Program) -> list[str]:
    """Return the units of a physical type with the factor 1."""
    types = (each for each in program.types.values() if isinstance(each, QuantitySymbol) and each.name == quantity)
    dimensions = [each.dimension for each in types]
    return [
        unit.name
        for unit in program.units.values()
        if unit.dimension in dimensions and unit.factor == 1 and unit.offset == 0
    ]


def _call_struct(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Write the default value of a struct as a call of its constructor."""
    span = error.primary.span
    kinds = (each for each in checked.program.types.values() if isinstance(each, TypeSymbol))
    if not any(each.kind is Kind.STRUCT and each.plan_name == span.text for each in kinds):
        return None
    title = f"wrote the default value of `{span.text}` as `{span.text}()`"
    return Rewriting(span.line, title, (Edit(span.end, span.end, "()"),))


_NUMBER_FOR_QUANTITY: Final = re.compile(r"expected `(\w+)`.*, found `(?:int|uint|float)`$")
_RULES: Final[Mapping[str, Callable[[Diagnostic, Checked], Rewriting | None]]] = {
    "E0211": _constrain_actor,
    "E0301": _give_unit,
    "E0325": _call_struct,
    "E0460": _move_modifiers,
}
