"""Messages of declarations and names (E0210 to E0298)."""

from __future__ import annotations

from seoro.lang.builtin_libraries import TYPES as DATA
from seoro.lang.builtin_libraries import import_hint
from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import listing, near, near_or_all
from seoro.lang.habits import METHODS, NAMES, TYPES, UNITS
from seoro.lang.source import Span


def duplicate(span: Span, what: str, name: str, first: Span) -> Diagnostic:
    """A second declaration of a name."""
    text = f"duplicate {what} `{name}`"
    hint = "rename or remove one of them"
    return error("E0210", span, text, hint, label="again here", other=first, remark="first declared here")


def unknown_type(
    span: Span, name: str, candidates: tuple[str, ...], what: str = "type", hint: str = ""
) -> Diagnostic:
    """An undeclared type."""
    habits = METHODS if what == "method or struct" else TYPES
    hint = hint or habits.get(name) or import_hint(name, DATA) or near(name, candidates)
    return error("E0211", span, f"unknown {what} `{name}`", hint)


def wrong_kind(span: Span, name: str, kind: str, expected: str) -> Diagnostic:
    """A name of one kind where another kind is needed."""
    return error("E0212", span, f"expected {expected}, but `{name}` is {kind}")


def unknown_unit(span: Span, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An undeclared unit."""
    unit = UNITS.get(name)
    if not candidates:
        hint = "the units of the standard come with `import osc.types`"
    elif unit in candidates:
        hint = f"a unit is one name: `{unit}`" if "/" in name else f"write `{unit}`"
    elif name.startswith("_") and name.replace("_", "").isdigit():
        hint = "numbers have no separators"
    else:
        hint = near(name, candidates)
    return error("E0213", span, f"unknown unit `{name}`", hint)


def unknown_base_unit(span: Span, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown SI base unit."""
    return error("E0214", span, f"unknown SI base unit `{name}`", f"the base units are {listing(candidates)}")


def unknown_field(span: Span, owner: str, name: str, candidates: tuple[str, ...], hint: str = "") -> Diagnostic:
    """An unknown member of a type."""
    hint = near(name, candidates) or hint or (f"its fields are {listing(candidates)}" if candidates else "")
    return error("E0215", span, f"{owner} has no field `{name}`", hint)


def unknown_name(span: Span, name: str, candidates: tuple[str, ...], invoked: tuple[str, ...]) -> Diagnostic:
    """An unknown name in an expression, in which names of invocations may lead to parameters."""
    hint = NAMES.get(name) or near(name, (*candidates, *invoked))
    if not hint and invoked:
        hint = f"the invocations are {listing(invoked)}"
    return error("E0216", span, f"unknown name `{name}`", hint)


def unknown_member(span: Span, enum: str, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown member of an enumeration, or a known one without the enumeration."""
    if name in candidates:
        hint = f"write a member of an enumeration as `{enum}!{name}`"
        return error("E0217", span, f"unknown name `{span.text}`", hint)
    return error(
        "E0217", span, f"`{enum}` has no member `{name}`", near_or_all(name, candidates, "its members are")
    )


def ambiguous_member(span: Span, name: str, enums: tuple[str, ...]) -> Diagnostic:
    """A member of several enumerations, where the type is not known."""
    hint = f"write {listing([f'{enum}!{name}' for enum in enums], 'or')}"
    return error("E0218", span, f"`{name}` is ambiguous: it is a member of {listing(enums)}", hint)


def cyclic_reference(span: Span, what: str, names: tuple[str, ...]) -> Diagnostic:
    """Declarations that refer to each other in a cycle."""
    return error("E0219", span, f"{what} form a cycle: {' -> '.join(names)}")


def too_many_bases(span: Span, limit: int) -> Diagnostic:
    """A chain of bases that exceeds the limit."""
    hint = "inherit from a type further up"
    return error("E0133", span, f"inherits from a chain of more than {limit} types", hint)


def invalid_base(span: Span, name: str, base: str) -> Diagnostic:
    """A scenario or action that inherits from one of an unrelated actor (7.3.8.1)."""
    hint = "both belong to no actor, or the base belongs to the same actor or one that it inherits from"
    return error("E0220", span, f"`{name}` cannot inherit from `{base}`", hint)


def ambiguous_name(span: Span, name: str, namespaces: tuple[str, ...]) -> Diagnostic:
    """A name that several namespaces in use export (7.7.4.2)."""
    hint = f"write {listing([f'{namespace}::{name}' for namespace in namespaces], 'or')}"
    return error("E0221", span, f"`{name}` is ambiguous: several namespaces in use export it", hint)


def unknown_namespace(span: Span, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """A namespace without definitions."""
    return error("E0222", span, f"unknown namespace `{name}`", near(name, candidates))


def unknown_export(span: Span, name: str) -> Diagnostic:
    """An exported name without a declaration."""
    return error("E0223", span, f"cannot export unknown name `{name}`")


def unconditional_base(span: Span, name: str, base: str) -> Diagnostic:
    """A type that inherits a conditional one without a condition (7.3.8.2.3)."""
    text = f"`{base}` depends on a condition, so `{name}` cannot inherit it without one"
    hint = f"add a condition: `inherits {base}(<field> == <value>)`"
    return error("E0224", span, text, hint)


def variable_determinant(span: Span, name: str, declared: Span) -> Diagnostic:
    """A conditional subtype that depends on a variable (7.3.8.2)."""
    text = f"the type of a value cannot depend on the variable `{name}`, which may change"
    hint = "declare it without `var`, as a parameter"
    return error("E0298", span, text, hint, other=declared, remark="declared as a variable here")
