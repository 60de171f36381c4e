"""Messages of `cover` and `record` (E0501 to E0521)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import listing, near, near_or_all, with_article
from seoro.lang.source import Span


def missing_name(span: Span, kind: str) -> Diagnostic:
    """An item without a name."""
    hint = f"the first argument is the name: `{kind}(speed_at_end, expression: ...)`"
    return error("E0501", span, f"missing name of this `{kind}`", hint)


def invalid_name(span: Span, kind: str) -> Diagnostic:
    """An expression in the place of an item's name."""
    hint = f"the sampled value follows the name: `{kind}(item, expression: {span.text.strip()})`"
    return error("E0502", span, "expected the name of the item, a single identifier", hint)


def duplicate_item(span: Span, kind: str, name: str, owner: str, first: Span, is_inherited: bool) -> Diagnostic:
    """A second item of the same name."""
    remark, hint = "first declared here", f"to change the first one: `{kind}(override: {name}, ...)`"
    if is_inherited:
        remark, hint = "inherited from here", "give it another name, and an `expression`"
    return error("E0503", span, f"duplicate item `{name}` of `{owner}`", hint, other=first, remark=remark)


def unknown_item_argument(span: Span, kind: str, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown argument of `cover` or `record`."""
    hint = near_or_all(name, candidates, "its arguments are")
    return error("E0504", span, f"`{kind}` has no argument `{name}`", hint)


def unnamed_argument(span: Span, kind: str, is_override: bool) -> Diagnostic:
    """A positional argument other than the name of the item."""
    text = "only the name of an item can be a positional argument"
    if is_override:
        text = "with `override`, every argument needs its name"
    return error("E0505", span, text, f"such as `{kind}(speed, unit: kph, range: [0..130], every: 10)`")


def nothing_to_sample(span: Span, name: str, owner: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An item without an expression whose name is not that of a field."""
    hint = near(name, candidates) or "name a field, or add `expression: ...`"
    return error("E0506", span, f"`{owner}` has no field `{name}`, and the item has no `expression`", hint)


def not_scalar(span: Span, name: str, found: str) -> Diagnostic:
    """An item whose value is a list, a range or a structure."""
    text = f"item `{name}` needs a single value"
    hint = "sample a number, a physical value, a boolean, an enumeration or a string, such as a field of it"
    return error("E0507", span, text, hint, label=f"this is {with_article(found)}")


def missing_unit(span: Span, name: str, found: str, units: tuple[str, ...]) -> Diagnostic:
    """An item of a physical type without a unit."""
    hint = f"add `unit: {units[0]}`" if units else ""
    hint += f" (or {listing(units[1:5], 'or')})" if units[1:] else ""
    return error("E0508", span, f"item `{name}` is {with_article(found)} and needs a `unit`", hint)


def invalid_unit(span: Span, unit: str, name: str, found: str, units: tuple[str, ...]) -> Diagnostic:
    """A unit that the value cannot be converted to."""
    text = f"item `{name}` is {with_article(found)} and cannot be given in `{unit}`"
    return error("E0509", span, text, f"its units are {listing(units[:8])}" if units else "omit the unit")


def excluded_argument(span: Span, name: str, reason: str, other: Span) -> Diagnostic:
    """An argument that another one excludes."""
    return error("E0510", span, f"`{name}` {reason}", other=other, remark="because of this")


def invalid_argument_value(span: Span, argument: str, expected: str, hint: str = "") -> Diagnostic:
    """An invalid value of an argument."""
    return error("E0511", span, f"`{argument}` takes {expected}", hint)


def no_buckets(span: Span, argument: str, name: str, found: str) -> Diagnostic:
    """`range`, `every` or `buckets` of an item that is not a number."""
    hint = "each of its values has its own bucket; `ignore` leaves values out"
    return error("E0512", span, f"`{argument}` is for numbers, but `{name}` is {with_article(found)}", hint)


def descending(span: Span, value: str, before: str, other: Span) -> Diagnostic:
    """Boundaries of buckets that are not in ascending order."""
    text = f"expected ascending boundaries, found {value} after {before}"
    return error("E0513", span, text, other=other, remark="this is greater")


def too_many_buckets(span: Span, limit: int) -> Diagnostic:
    """A range in more buckets than supported."""
    return error("E0514", span, f"this makes more than {limit:,} buckets", "use wider buckets, or a shorter range")


def path_of_event(span: Span) -> Diagnostic:
    """A path in the place of an event's name."""
    hint = f"declare `event sampled is @{span.text.strip().lstrip('@')}` and write `event: sampled`"
    return error("E0515", span, "`event` takes the name of an event of the same type", hint)


def not_constant(span: Span, argument: str, name: str) -> Diagnostic:
    """Something in `ignore` or `illegal` that is neither the item nor a constant."""
    return error("E0516", span, f"`{argument}` may contain only `{name}`, the value of the item, and constants")


def target_of_record(span: Span, name: str, reason: str) -> Diagnostic:
    """`target` of a record."""
    hint = "omit it" if reason else "omit it, or use `cover`"
    return error("E0517", span, f"`{name}` is a record{reason}, which has no `target`", hint)


def unknown_item(span: Span, name: str, owner: str, candidates: tuple[str, ...], later: Span | None) -> Diagnostic:
    """An unknown item, or one that is defined later."""
    if later is not None:
        text, hint = f"item `{name}` is not defined yet", "move this item below the definition"
        return error("E0518", span, text, hint, other=later, remark="it is defined here, too late")
    hint = near_or_all(name, candidates, "its items are") or "it has no items before this one"
    return error("E0518", span, f"`{owner}` has no item `{name}`", hint)


def different_event(span: Span, name: str, event: str, cross_event: str, item: Span) -> Diagnostic:
    """An item of a cross that is sampled at another event."""
    text = f"the cross is sampled at `{cross_event}`, but `{name}` at `{event}`"
    hint = "a cross combines items that are sampled at its own event"
    return error("E0519", span, text, hint, other=item, remark=f"sampled at `{event}`")


def invalid_item_override(span: Span, reason: str, item: Span, hint: str = "") -> Diagnostic:
    """An override that the item does not allow (7.5.6)."""
    return error("E0520", span, reason, hint, other=item, remark="the item is here")


def misplaced_item(span: Span, kind: str, name: str) -> Diagnostic:
    """An item of a global parameter, outside of a type."""
    hint = f"write `{kind}(..., expression: {name})` in the scenario whose events sample it"
    return error("E0521", span, f"`{kind}` is a member of a struct, an actor or a scenario", hint)
