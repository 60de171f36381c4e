"""Messages of types and expressions (E0301 to E0330, E0348, E0390 to E0395)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error, warning
from seoro.lang.diagnostics import with_article
from seoro.lang.habits import mismatch_help
from seoro.lang.source import Span


def mismatch(span: Span, expected: str, found: str, context: str = "", hint: str = "") -> Diagnostic:
    """A value of the wrong type."""
    purpose = f" for {context}" if context else ""
    hint = hint or mismatch_help(context, expected.strip("`"), found.strip("`"), span.text)
    text = f"expected {expected}{purpose}, found {found}"
    return error("E0301", span, text, hint, label=f"this is {with_article(found)}")


def incompatible_operands(
    span: Span, right: Span, operator: str, left_type: str, right_type: str, hint: str = ""
) -> Diagnostic:
    """Operands that an arithmetic operator cannot combine."""
    verb = {"+": "added", "-": "subtracted", "*": "multiplied"}.get(operator, "divided")
    text = f"{left_type} and {right_type} cannot be {verb}"
    return _operands("E0312", span, right, text, left_type, right_type, hint)


def incomparable_operands(span: Span, right: Span, operator: str, left_type: str, right_type: str) -> Diagnostic:
    """Operands that cannot be compared."""
    text = f"{left_type} and {right_type} cannot be compared by `{operator}`"
    return _operands("E0313", span, right, text, left_type, right_type)


def _operands(
    code: str, left: Span, right: Span, text: str, left_type: str, right_type: str, hint: str = ""
) -> Diagnostic:
    """Create an error about two operands of unlike types."""
    label, remark = (f"this is {with_article(type_)}" for type_ in (left_type, right_type))
    return error(code, left, text, hint, label, right, remark)


def unordered(span: Span, operator: str, found: str) -> Diagnostic:
    """An order of values that have none."""
    hint = "only numbers have an order; others compare by `==`, `!=` and `in`"
    return error("E0314", span, f"`{operator}` does not apply to {found}", hint)


def not_bool(span: Span, operator: str, found: str) -> Diagnostic:
    """An operand other than a boolean."""
    return error("E0315", span, f"`{operator}` needs bool, found {found}")


def not_number(span: Span, operator: str, found: str) -> Diagnostic:
    """An operand other than a number."""
    return error("E0316", span, f"`{operator}` needs a number, found {found}")


def not_a_container(span: Span, found: str) -> Diagnostic:
    """A right operand of `in` other than a list or a range."""
    return error("E0317", span, f"`in` needs a list or a range, found {found}")


def no_common_type(span: Span, other: Span, what: str, left: str, right: str) -> Diagnostic:
    """Values without a common type."""
    return _operands("E0318", span, other, f"{what} have no common type", right, left)


def no_fields(span: Span, found: str) -> Diagnostic:
    """A member access on a value without members."""
    return error("E0319", span, f"{found} has no fields")


def not_a_list(span: Span, found: str) -> Diagnostic:
    """An index on a value other than a list."""
    return error("E0320", span, f"only lists have elements, found {found}")


def invalid_index(span: Span, found: str) -> Diagnostic:
    """An index other than an integer."""
    return error("E0321", span, f"the index of a list is an integer, found {found}")


def not_numeric_range(span: Span, found: str) -> Diagnostic:
    """A range of something other than numbers (7.3.5.2.2)."""
    return error("E0322", span, f"a range consists of numbers, found {found}")


def list_of_list(span: Span) -> Diagnostic:
    """A list of lists (7.3.5.2.1)."""
    return error("E0323", span, "a list cannot contain lists", "put the inner list into a struct")


def wrong_unit_dimension(span: Span, name: str, quantity: str, expected: str, found: str) -> Diagnostic:
    """A unit with other exponents than its type (7.3.4)."""
    return error("E0324", span, f"`{name}` is in {found}, but `{quantity}` is in {expected}")


def not_a_value(span: Span, name: str, kind: str, hint: str = "") -> Diagnostic:
    """A name in an expression that does not denote a value."""
    return error("E0325", span, f"`{name}` is {kind}, not a value", hint)


def not_callable(span: Span, name: str, hint: str = "") -> Diagnostic:
    """Arguments for something that takes none."""
    return error("E0326", span, f"`{name}` takes no arguments", hint)


def negative_uint(span: Span) -> Diagnostic:
    """A negative number for `uint`."""
    return error("E0327", span, "`uint` cannot hold negative numbers", "use `int`")


def int_too_large(span: Span) -> Diagnostic:
    """A number that fits into `uint`, but not into `int`."""
    return error("E0328", span, "this number is too large for `int`", "use `uint`")


def invalid_condition(span: Span) -> Diagnostic:
    """A condition of inheritance without a value of its field (7.3.8.2)."""
    hint = "a condition compares a `bool` or an enumeration with one of its values"
    return error("E0329", span, "invalid condition: expected a value of the field", hint)


def fixed_by_condition(span: Span, owner: str, name: str, value: str) -> Diagnostic:
    """A value for a field that the condition of a conditional type fixes to another one (7.3.8.2)."""
    hint = f"omit it, or use the type that `{owner}` inherits"
    return error("E0330", span, f"`{name}` of `{owner}` is always {value}", hint)


def label_as_value(span: Span, name: str, is_invocation: bool, is_early: bool) -> Diagnostic:
    """A label in an expression, where it is not a value or not one of an invocation (7.6.2.2).

    Args:
        span: The label.
        name: Its name.
        is_invocation: Whether the label belongs to an invocation.
        is_early: Whether the expression is evaluated before the scenario runs.
    """
    if not is_invocation:
        hint = "only the label of an invocation has fields: those of the invoked behavior"
    elif is_early:
        hint = "nothing runs yet when this is evaluated: use its fields below `do`, in `on`, or in `sample`"
    else:
        hint = f"write `{name}.<field>` for a field of the invoked behavior"
    return error("E0348", span, f"`{name}` is a label, not a value", hint)


def bare_number(span: Span, unit: str) -> Diagnostic:
    """A number without a unit for a physical parameter: an extension to the standard."""
    return warning("E0390", span, "a number without a unit", f"it is read in {unit}; the standard requires a unit")


def struct_constructor(span: Span, name: str) -> Diagnostic:
    """Construction of a struct from arguments: an extension to the standard."""
    hint = "it constructs a value; other implementations may not support it"
    return warning("E0391", span, f"`{name}(...)` is an extension to the standard", hint)


def library_import(span: Span, name: str) -> Diagnostic:
    """Import of a library that is not part of the standard."""
    hint = "other implementations may not have it"
    return warning("E0392", span, f"`{name}` is not a module of the standard, which reserves `osc`", hint)


def any_argument(span: Span, parameter: str, declared: str) -> Diagnostic:
    """An argument of another type than declared, for a parameter that accepts any."""
    return warning("E0393", span, f"`{parameter}` is declared as {declared}, and accepts any type here")


def order_of_range(span: Span, operator: str) -> Diagnostic:
    """An order of a range and a number, which holds if it holds for the whole range: an extension."""
    hint = "compare a bound: `.lower()` or `.upper()`"
    return warning("E0394", span, f"`{operator}` of a range and a number is an extension to the standard", hint)


def reserved_namespace(span: Span, name: str) -> Diagnostic:
    """A namespace with a name that the standard reserves."""
    hint = "use a name such as `com_example_robots`"
    return warning("E0395", span, f"the standard reserves `{name}`, as all namespaces that begin with `std`", hint)
