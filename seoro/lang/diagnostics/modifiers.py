"""Messages of modifiers and their application (E0460 to E0471)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.diagnostics import a, listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.provided import MODIFIERS, import_hint
from seoro.lang.source import Span


class ModifierInvoked(Frozen):
    """A modifier where a scenario or an action is invoked."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"apply it to a behavior: write `{self.name}(...)` into a `with:` block below it"
        return error("E0460", self.span, f"`{self.name}` is a modifier, not a scenario or an action", help=hint)


class BehaviorApplied(Frozen):
    """A scenario, an action or a method where a modifier is applied."""

    span: Span
    name: str
    kind: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "scenarios and actions are invoked below `do`, methods without a result by `call`"
        return error("E0461", self.span, f"`{self.name}` is {a(f'`{self.kind}`')}, not a modifier", help=hint)


class UnknownModifier(Frozen):
    """The application of what is no modifier."""

    span: Span
    name: str
    actor: str | None
    candidates: tuple[str, ...]
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        what = f"actor `{self.actor}` has no modifier" if self.actor else "unknown modifier"
        hint = self.help or import_hint(self.name, MODIFIERS, self.actor) or near(self.name, self.candidates)
        return error("E0462", self.span, f"{what} `{self.name}`", help=hint)


class ModifierOfNoActor(Frozen):
    """A modifier applied to something that is no actor."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"what stands before a modifier is an actor, this is {a(self.found)}"
        return error("E0463", self.span, text)


class WrongModified(Frozen):
    """A modifier of one scenario, applied to something else (7.3.12.2)."""

    span: Span
    name: str
    needed: str
    found: str
    declared: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.declared, f"declared for `{self.needed}` here")
        text = f"`{self.name}` modifies `{self.needed}`, and this is {self.found}"
        return error("E0464", self.span, text, before)


class OverrideArguments(Frozen):
    """Arguments that `override` does not take (7.3.12.1.1)."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "write `override(a, b)` to end the behavior labelled `a` when `b` starts"
        return error(
            "E0465", self.span, "`override` takes two labels and perhaps a mode, without names", help=hint
        )


class NotALabel(Frozen):
    """What should be a label of the scenario."""

    span: Span
    known: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = self.span.text
        hint = near(text, self.known) or (f"the labels are {listing(self.known)}" if self.known else "")
        return error("E0466", self.span, f"`{text}` is no label here", help=hint)


class UnknownMode(Frozen):
    """What is no mode of `override`."""

    span: Span
    modes: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text, hint = self.span.text, f"the modes are {listing(self.modes)}"
        return error("E0467", self.span, f"`{text}` is no mode of `override`", help=near(text, self.modes) or hint)


class OverrideOfItself(Frozen):
    """`override(a, a)`."""

    span: Span
    label: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0468", self.span, f"`{self.label}` cannot override itself")


class OverrideDeclared(Frozen):
    """A declaration of the modifier that is part of the language, which would always be meant instead."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0470", self.span, "the modifier `override` is part of the language", help="choose another name"
        )


class MisplacedMember(Frozen):
    """A member that only scenarios and actions have (7.2.2.2.6)."""

    span: Span
    word: str
    name: str
    kind: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.word}` belongs to scenarios and actions, and `{self.name}` is {self.kind}"
        return error("E0469", self.span, text)


class LacksParameter(Frozen):
    """A modifier without `of`, applied to what lacks a parameter that the modifier uses (7.3.12.1.2)."""

    span: Span
    name: str
    parameter: str
    found: str
    used: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` uses `it.{self.parameter}`, which {self.found} does not have"
        hint = f"`{self.parameter}` is a parameter of `parallel`"
        if self.parameter == "duration":
            hint = "compositions have it, and invocations of what declares no other parameter of that name"
        return error("E0471", self.span, text, Label(self.used, "used here"), help=hint)
