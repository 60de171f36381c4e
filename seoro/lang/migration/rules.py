"""Rewriting of one error; `None` if it needs a decision."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.migration.edits import Edit, Rewriting, indent_of, line_break, line_end, line_start
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import Kind, TypeSymbol
from seoro.lang.tree import find

INDENT: Final = "    "


def rewriting_of(error: Diagnostic, checked: Checked) -> Rewriting | None:
    """Return the rewriting that removes an error of the entry file, or None.

    Args:
        error: The error.
        checked: The checked scenario.
    """
    rule = _RULES.get(error.code)
    return rule(error.primary.span, checked) if rule is not None else None


# ---------------------------------------------------------------- modifiers among members


def _move_modifier(span: Span, checked: Checked) -> Rewriting | None:
    """Move a modifier among the members of a composition into the `with:` block of that composition."""
    file, tree = span.file, checked.sources.entry.tree
    found = next(_compositions_with(span, tree), None)
    if found is None:
        return None
    composition, member = found
    others = [each for each in composition.members if each is not member]
    start, end = line_start(file, member.span.start), line_end(file, member.span.end - 1)
    if not others or file.text[start : member.span.start].strip() or _several_modifiers(composition, checked):
        return None
    place = _with_place(file, composition, max(others, key=lambda each: each.span.end))
    if place is None:
        return None
    offset, prefix, suffix, is_inside = place
    moved = file.text[member.body.span.start : end]
    if offset == start:
        return None
    after = end + len(line_break(file)) if file.text[end : end + 1] else end
    removed = Edit(start, after, "") if after > end else Edit(start - len(line_break(file)), end, "")
    inserted = Edit(offset, offset, f"{prefix}{moved}{suffix}")
    name = member.body.span.text.partition("(")[0]
    title = f"moved `{name}` into the `with:` block" + ("" if is_inside else " of its composition")
    return Rewriting(span.line, title, (removed, inserted))


def _compositions_with(span: Span, tree: ast.OscFile) -> Iterator[tuple[ast.Composition, ast.DoMember]]:
    for composition in find(tree, ast.Composition):
        for member in composition.members:
            body = member.body
            if isinstance(body, ast.BehaviorInvocation) and body.span.start <= span.start < body.span.end:
                yield composition, member


def _several_modifiers(composition: ast.Composition, checked: Checked) -> bool:
    """Whether more than one member is a modifier, whose order would need a decision."""
    names = {symbol.plan_name for symbol in checked.program.modifiers.values()}
    bodies = (member.body for member in composition.members)
    called = (body.span.text.partition("(")[0] for body in bodies if isinstance(body, ast.BehaviorInvocation))
    return sum(name in names for name in called) > 1


def _with_place(
    file: SourceFile, composition: ast.Composition, last: ast.DoMember
) -> tuple[int, str, str, bool] | None:
    """Return the offset, the text before and after, and whether a block exists; None if it is on one line."""
    newline = line_break(file)
    block = composition.modifications
    if block is not None:
        first = block.members[0].span.start
        start = line_start(file, first)
        return (start, indent_of(file, first), newline, True) if not file.text[start:first].strip() else None
    indent = indent_of(file, composition.span.start)
    inner = indent_of(file, last.span.start)
    unit = inner.removeprefix(indent) if inner.startswith(indent) and inner != indent else INDENT
    text = file.text[: last.span.end].rstrip()
    return line_end(file, len(text) - 1), f"{newline}{indent}with:{newline}{indent}{unit}", "", False


# ---------------------------------------------------------------- constructors of actors


def _constrain_actor(span: Span, checked: Checked) -> Rewriting | None:
    """Write the constructor of an actor as constraints of its fields."""
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


_RULES: Final[Mapping[str, Callable[[Span, Checked], Rewriting | None]]] = {
    "E0211": _constrain_actor,
    "E0460": _move_modifier,
}
