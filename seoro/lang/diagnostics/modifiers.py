"""Messages of modifiers and their application (E0460 to E0471)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.import_hints import MODIFIERS, import_hint
from seoro.lang.source import Span


class ModifierInvoked(TemplateMessage):
    """Invocation of a modifier."""

    CODE = "E0460"
    TEXT = "`{name}` is a modifier; expected a scenario or an action"
    HELP = "apply it to a behavior: write `{name}(...)` into a `with:` block below it"

    name: str


class BehaviorApplied(TemplateMessage):
    """A scenario, an action or a method that is applied like a modifier."""

    CODE = "E0461"
    TEXT = "`{name}` is {_kind:a}; expected a modifier"
    HELP = "invoke scenarios and actions below `do`, methods without a result by `call`"

    name: str
    kind: str

    @property
    def _kind(self) -> str:
        return f"`{self.kind}`"


class UnknownModifier(TemplateMessage):
    """Application of an unknown modifier."""

    CODE = "E0462"
    TEXT = ("actor `{actor}` has no modifier `{name}`", "unknown modifier `{name}`")
    HELP = ("{help}", "{_imported}", "{near}")

    name: str
    actor: str | None
    candidates: tuple[str, ...]
    help: str = ""

    @property
    def _imported(self) -> str:
        return import_hint(self.name, MODIFIERS, self.actor)


class ModifierOfNoActor(TemplateMessage):
    """A modifier of something other than an actor."""

    CODE = "E0463"
    TEXT = "expected an actor before the modifier, found {found:a}"

    found: str


class InvalidModified(TemplateMessage):
    """A modifier of one scenario that is applied to something else (7.3.12.2)."""

    CODE = "E0464"
    TEXT = "`{name}` modifies `{expected}`, but this is {found}"
    OTHERS = (("declared", "declared for `{expected}` here"),)

    name: str
    expected: str
    found: str
    declared: Span


class OverrideArguments(TemplateMessage):
    """Invalid arguments of `override` (7.3.12.1.1)."""

    CODE = "E0465"
    TEXT = "`override` takes two labels and an optional mode, without names"
    HELP = "write `override(a, b)` to end the behavior labelled `a` when `b` starts"


class UnknownLabel(TemplateMessage):
    """An unknown label in `override`."""

    CODE = "E0466"
    TEXT = "unknown label `{name}`"
    HELP = ("{near}", "the labels are {candidates:and}")

    candidates: tuple[str, ...]

    @property
    def name(self) -> str:
        """The label as written."""
        return self.span.text


class UnknownMode(TemplateMessage):
    """An unknown mode of `override`."""

    CODE = "E0467"
    TEXT = "unknown mode `{name}` of `override`"
    HELP = ("{near}", "the modes are {candidates:and}")

    candidates: tuple[str, ...]

    @property
    def name(self) -> str:
        """The mode as written."""
        return self.span.text


class OverrideOfItself(TemplateMessage):
    """`override(a, a)`."""

    CODE = "E0468"
    TEXT = "`{label}` cannot override itself"

    label: str


class MisplacedMember(TemplateMessage):
    """A member that only scenarios and actions have (7.2.2.2.6)."""

    CODE = "E0469"
    TEXT = "`{word}` belongs to scenarios and actions, but `{name}` is {kind}"

    word: str
    name: str
    kind: str


class OverrideDeclared(TemplateMessage):
    """A modifier named `override`, which would be hidden by that of the language."""

    CODE = "E0470"
    TEXT = "the modifier `override` is part of the language"
    HELP = "choose another name"


class LacksParameter(TemplateMessage):
    """A modifier without `of` that uses a missing parameter of the modified behavior (7.3.12.1.2)."""

    CODE = "E0471"
    TEXT = "`{name}` uses `it.{parameter}`, which {found} does not have"
    HELP = (
        "{_is_duration:if}compositions have it, and invocations of behaviors without a parameter of that name",
        "`{parameter}` is a parameter of `parallel`",
    )
    OTHERS = (("used", "used here"),)

    name: str
    parameter: str
    found: str
    used: Span

    @property
    def _is_duration(self) -> bool:
        return self.parameter == "duration"
