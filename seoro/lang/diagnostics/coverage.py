"""Messages of `cover` and `record` (E0501 to E0521)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.source import Span


class MissingName(TemplateMessage):
    """An item without a name."""

    CODE = "E0501"
    TEXT = "missing name of this `{kind}`"
    HELP = "the first argument is the name: `{kind}(speed_at_end, expression: ...)`"

    kind: str


class InvalidName(TemplateMessage):
    """An expression in the place of an item's name."""

    CODE = "E0502"
    TEXT = "expected the name of the item, a single identifier"
    HELP = "the sampled value follows the name: `{kind}(item, expression: {_value})`"

    kind: str

    @property
    def _value(self) -> str:
        return self.span.text.strip()


class DuplicateItem(TemplateMessage):
    """A second item of the same name."""

    CODE = "E0503"
    TEXT = "duplicate item `{name}` of `{owner}`"
    HELP = (
        "{is_inherited:if}give it another name, and an `expression`",
        "to change the first one: `{kind}(override: {name}, ...)`",
    )
    OTHERS = (("first", ("{is_inherited:if}inherited from here", "first declared here")),)

    kind: str
    name: str
    owner: str
    first: Span
    is_inherited: bool


class UnknownItemArgument(TemplateMessage):
    """An unknown argument of `cover` or `record`."""

    CODE = "E0504"
    TEXT = "`{kind}` has no argument `{name}`"
    HELP = ("{near}", "its arguments are {candidates:and}")

    kind: str
    name: str
    candidates: tuple[str, ...]


class UnnamedArgument(TemplateMessage):
    """A positional argument other than the name of the item."""

    CODE = "E0505"
    TEXT = (
        "{is_override:if}with `override`, every argument needs its name",
        "only the name of an item can be a positional argument",
    )
    HELP = ("such as `{kind}(speed, unit: kph, range: [0..130], every: 10)`",)

    kind: str
    is_override: bool


class NothingToSample(TemplateMessage):
    """An item without an expression whose name is not that of a field."""

    CODE = "E0506"
    TEXT = "`{owner}` has no field `{name}`, and the item has no `expression`"
    HELP = ("{near}", "name a field, or add `expression: ...`")

    name: str
    owner: str
    candidates: tuple[str, ...]


class NotScalar(TemplateMessage):
    """An item whose value is a list, a range or a structure."""

    CODE = "E0507"
    TEXT = "item `{name}` needs a single value"
    HELP = "sample a number, a physical value, a boolean, an enumeration or a string, such as a field of it"
    LABEL = "this is {found:a}"

    name: str
    found: str


class MissingUnit(TemplateMessage):
    """An item of a physical type without a unit."""

    CODE = "E0508"
    TEXT = "item `{name}` is {found:a} and needs a `unit`"
    HELP = ("add `unit: {_unit}` (or {_others:or})", "add `unit: {_unit}`")

    name: str
    found: str
    units: tuple[str, ...]

    @property
    def _unit(self) -> str:
        return self.units[0] if self.units else ""

    @property
    def _others(self) -> tuple[str, ...]:
        return self.units[1:5]


class InvalidUnit(TemplateMessage):
    """A unit that the value cannot be converted to."""

    CODE = "E0509"
    TEXT = "item `{name}` is {found:a} and cannot be given in `{unit}`"
    HELP = ("its units are {_shown:and}", "omit the unit")

    unit: str
    name: str
    found: str
    units: tuple[str, ...]

    @property
    def _shown(self) -> tuple[str, ...]:
        return self.units[:8]


class ExcludedArgument(TemplateMessage):
    """An argument that another one excludes."""

    CODE = "E0510"
    TEXT = "`{name}` {reason}"
    OTHERS = (("other", "because of this"),)

    name: str
    reason: str
    other: Span


class InvalidArgumentValue(TemplateMessage):
    """An invalid value of an argument."""

    CODE = "E0511"
    TEXT = "`{argument}` takes {expected}"
    HELP = "{help}"

    argument: str
    expected: str
    help: str = ""


class NoBuckets(TemplateMessage):
    """`range`, `every` or `buckets` of an item that is not a number."""

    CODE = "E0512"
    TEXT = "`{argument}` is for numbers, but `{name}` is {found:a}"
    HELP = "each of its values has its own bucket; `ignore` leaves values out"

    argument: str
    name: str
    found: str


class Descending(TemplateMessage):
    """Boundaries of buckets that are not in ascending order."""

    CODE = "E0513"
    TEXT = "expected ascending boundaries, found {value} after {before}"
    OTHERS = (("other", "this is greater"),)

    value: str
    before: str
    other: Span


class TooManyBuckets(TemplateMessage):
    """A range in more buckets than supported."""

    CODE = "E0514"
    TEXT = "this makes more than {limit:,} buckets"
    HELP = "use wider buckets, or a shorter range"

    limit: int


class PathOfEvent(TemplateMessage):
    """A path in the place of an event's name."""

    CODE = "E0515"
    TEXT = "`event` takes the name of an event of the same type"
    HELP = "declare `event sampled is @{_path}` and write `event: sampled`"

    @property
    def _path(self) -> str:
        return self.span.text.strip().lstrip("@")


class NotConstant(TemplateMessage):
    """Something in `ignore` or `illegal` that is neither the item nor a constant."""

    CODE = "E0516"
    TEXT = "`{argument}` may contain only `{name}`, the value of the item, and constants"

    argument: str
    name: str


class TargetOfRecord(TemplateMessage):
    """`target` of a record."""

    CODE = "E0517"
    TEXT = "`{name}` is a record{reason}, which has no `target`"
    HELP = ("{reason:if}omit it", "omit it, or use `cover`")

    name: str
    reason: str


class UnknownItem(TemplateMessage):
    """An unknown item, or one that is defined later."""

    CODE = "E0518"
    TEXT = ("{later:if}item `{name}` is not defined yet", "`{owner}` has no item `{name}`")
    HELP = (
        "{later:if}move this item below the definition",
        "{near}",
        "its items are {candidates:and}",
        "it has no items before this one",
    )
    OTHERS = (("later", "it is defined here, too late"),)

    name: str
    owner: str
    candidates: tuple[str, ...]
    later: Span | None


class DifferentEvent(TemplateMessage):
    """An item of a cross that is sampled at another event."""

    CODE = "E0519"
    TEXT = "the cross is sampled at `{cross_event}`, but `{name}` at `{event}`"
    HELP = "a cross combines items that are sampled at its own event"
    OTHERS = (("item", "sampled at `{event}`"),)

    name: str
    event: str
    cross_event: str
    item: Span


class InvalidItemOverride(TemplateMessage):
    """An override that the item does not allow (7.5.6)."""

    CODE = "E0520"
    TEXT = "{reason}"
    HELP = "{help}"
    OTHERS = (("item", "the item is here"),)

    reason: str
    item: Span
    help: str = ""


class MisplacedItem(TemplateMessage):
    """An item of a global parameter, outside of a type."""

    CODE = "E0521"
    TEXT = "`{kind}` is a member of a struct, an actor or a scenario"
    HELP = "write `{kind}(..., expression: {name})` in the scenario whose events sample it"

    kind: str
    name: str
