"""Messages of `cover` and `record` (E0501 to E0521)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.diagnostics import a, listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class MissingName(Frozen):
    """An item without a name."""

    span: Span
    kind: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"the first argument is the name: `{self.kind}(speed_at_end, expression: ...)`"
        return error("E0501", self.span, f"this `{self.kind}` has no name", help=hint)


class NotAName(Frozen):
    """Something else where the name of an item is needed."""

    span: Span
    kind: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"what is to be sampled follows the name: `{self.kind}(item, expression: {self.span.text.strip()})`"
        return error("E0502", self.span, "the name of an item is a single identifier", help=hint)


class SecondItem(Frozen):
    """A second item of the same name."""

    span: Span
    kind: str
    name: str
    owner: str
    first: Span
    is_inherited: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "inherited from here" if self.is_inherited else "the first one is here")
        change = f"to change the first one: `{self.kind}(override: {self.name}, ...)`"
        hint = "give it another name, and an `expression`" if self.is_inherited else change
        return error("E0503", self.span, f"`{self.owner}` has an item `{self.name}` already", before, help=hint)


class UnknownItemArgument(Frozen):
    """A named argument that `cover` and `record` do not have."""

    span: Span
    kind: str
    name: str
    known: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.known) or f"there are {listing(self.known)}"
        return error("E0504", self.span, f"`{self.kind}` has no argument `{self.name}`", help=hint)


class UnnamedArgument(Frozen):
    """A positional argument other than the name of the item."""

    span: Span
    kind: str
    is_override: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        what = "with `override`, every argument needs its name" if self.is_override else "only the name of an item"
        text = what if self.is_override else f"{what} stands without the name of its argument"
        hint = f"such as `{self.kind}(speed, unit: kph, range: [0..130], every: 10)`"
        return error("E0505", self.span, text, help="" if self.is_override else hint)


class NothingToSample(Frozen):
    """An item without an expression whose name is no field."""

    span: Span
    name: str
    owner: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = (
            near(self.name, self.candidates) or "name a field, or say what is to be sampled by `expression: ...`"
        )
        text = f"`{self.name}` is no field of `{self.owner}`, and the item has no `expression`"
        return error("E0506", self.span, text, help=hint)


class NotScalar(Frozen):
    """An item whose value is a list, a range or a structure."""

    span: Span
    name: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "sample a number, a physical value, a boolean, an enumeration or a string, such as a field of it"
        text = f"item `{self.name}` needs a single value"
        return error("E0507", self.span, text, label=f"this is {a(self.found)}", help=hint)


class MissingUnit(Frozen):
    """An item of a physical type without a unit."""

    span: Span
    name: str
    found: str
    units: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"add `unit: {self.units[0]}`" if self.units else ""
        others = listing(self.units[1:5], "or")
        hint += f" (or {others})" if others else ""
        text = f"item `{self.name}` is {a(self.found)} and needs a `unit`"
        return error("E0508", self.span, text, help=hint)


class WrongUnit(Frozen):
    """A unit for a value that cannot be converted into it."""

    span: Span
    unit: str
    name: str
    found: str
    units: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"its units are {listing(self.units[:8])}" if self.units else "leave the unit out"
        text = f"item `{self.name}` is {a(self.found)} and cannot be given in `{self.unit}`"
        return error("E0509", self.span, text, help=hint)


class ExcludedArgument(Frozen):
    """An argument that another one excludes."""

    span: Span
    name: str
    reason: str
    other: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0510", self.span, f"`{self.name}` {self.reason}", Label(self.other, "because of this"))


class WrongArgumentValue(Frozen):
    """A value of an argument that is not what it takes."""

    span: Span
    argument: str
    needed: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0511", self.span, f"`{self.argument}` takes {self.needed}", help=self.help)


class NoBuckets(Frozen):
    """`range`, `every` or `buckets` for values that are no numbers."""

    span: Span
    argument: str
    name: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.argument}` is for numbers, and `{self.name}` is {a(self.found)}"
        hint = "each of its values has a bucket of its own; `ignore` leaves values out"
        return error("E0512", self.span, text, help=hint)


class Descending(Frozen):
    """Boundaries of buckets that are not in order."""

    span: Span
    value: str
    before: str
    other: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        label = Label(self.other, "this is greater")
        return error("E0513", self.span, f"boundaries ascend, and {self.value} follows {self.before}", label)


class TooManyBuckets(Frozen):
    """A range in more buckets than anyone can look at."""

    span: Span
    limit: int

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"this makes more than {self.limit:,} buckets"
        return error("E0514", self.span, text, help="take wider slices, or a shorter range")


class PathOfEvent(Frozen):
    """A path where the name of an event of the same type is needed."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        path = self.span.text.strip().lstrip("@")
        hint = f"declare `event sampled is @{path}` and write `event: sampled`"
        return error("E0515", self.span, "`event` takes the name of an event of the same type", help=hint)


class NotConstant(Frozen):
    """Something in `ignore` or `illegal` that is neither the item nor a constant."""

    span: Span
    argument: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.argument}` may contain only `{self.name}`, the value of the item, and constants"
        return error("E0516", self.span, text)


class TargetOfRecord(Frozen):
    """`target` of a record."""

    span: Span
    name: str
    reason: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "leave it out, or use `cover`" if not self.reason else "leave it out"
        return error(
            "E0517", self.span, f"`{self.name}` is a record{self.reason}, which has no `target`", help=hint
        )


class UnknownItem(Frozen):
    """An item that is not there, or not yet."""

    span: Span
    name: str
    owner: str
    candidates: tuple[str, ...]
    later: Span | None

    def diagnostic(self) -> Diagnostic:
        """The message."""
        if self.later is not None:
            label = Label(self.later, "it is defined here, too late")
            return error("E0518", self.span, f"item `{self.name}` is not defined yet", label)
        hint = near(self.name, self.candidates)
        if not hint:
            hint = f"it has {listing(self.candidates)}" if self.candidates else "it has no items before this one"
        return error("E0518", self.span, f"`{self.owner}` has no item `{self.name}`", help=hint)


class OtherEvent(Frozen):
    """An item of a cross that is sampled at another event."""

    span: Span
    name: str
    event: str
    cross_event: str
    item: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        label = Label(self.item, f"sampled at `{self.event}`")
        text = f"the cross is sampled at `{self.cross_event}`, and `{self.name}` is not"
        hint = "only items with the same event as the cross can be combined"
        return error("E0519", self.span, text, label, help=hint)


class WrongItemOverride(Frozen):
    """An override that the item does not allow (7.5.6)."""

    span: Span
    reason: str
    item: Span
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0520", self.span, self.reason, Label(self.item, "the item is here"), help=self.help)


class MisplacedItem(Frozen):
    """An item of a global parameter, which is no member of a type."""

    span: Span
    kind: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.kind}` is a member of a struct, an actor or a scenario"
        hint = f"write `{self.kind}(..., expression: {self.name})` in the scenario whose events sample it"
        return error("E0521", self.span, text, help=hint)
