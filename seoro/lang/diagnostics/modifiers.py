"""Messages of modifiers and their application (E0460 to E0471)."""

from __future__ import annotations

from seoro.lang.builtin_libraries import MODIFIERS, import_hint
from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import near, near_or_all, with_article
from seoro.lang.source import Span


def modifier_invoked(span: Span, name: str) -> Diagnostic:
    """Invocation of a modifier."""
    hint = f"apply it to a behavior: write `{name}(...)` into a `with:` block below it"
    return error("E0460", span, f"`{name}` is a modifier; expected a scenario or an action", hint)


def behavior_applied(span: Span, name: str, kind: str) -> Diagnostic:
    """A scenario, an action or a method that is applied like a modifier."""
    hint = "invoke scenarios and actions below `do`, methods without a result by `call`"
    return error("E0461", span, f"`{name}` is {with_article(f'`{kind}`')}; expected a modifier", hint)


def unknown_modifier(
    span: Span, name: str, actor: str | None, candidates: tuple[str, ...], hint: str = ""
) -> Diagnostic:
    """Application of an unknown modifier."""
    text = f"actor `{actor}` has no modifier `{name}`" if actor else f"unknown modifier `{name}`"
    hint = hint or import_hint(name, MODIFIERS, actor) or near(name, candidates)
    return error("E0462", span, text, hint)


def modifier_of_no_actor(span: Span, found: str) -> Diagnostic:
    """A modifier of something other than an actor."""
    return error("E0463", span, f"expected an actor before the modifier, found {with_article(found)}")


def invalid_modified(span: Span, name: str, expected: str, found: str, declared: Span) -> Diagnostic:
    """A modifier of one scenario that is applied to something else (7.3.12.2)."""
    text = f"`{name}` modifies `{expected}`, but this is {found}"
    return error("E0464", span, text, other=declared, remark=f"declared for `{expected}` here")


def override_arguments(span: Span) -> Diagnostic:
    """Invalid arguments of `override` (7.3.12.1.1)."""
    hint = "write `override(a, b)` to end the behavior labelled `a` when `b` starts"
    return error("E0465", span, "`override` takes two labels and an optional mode, without names", hint)


def unknown_label(span: Span, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown label in `override`."""
    hint = near_or_all(span.text, candidates, "the labels are")
    return error("E0466", span, f"unknown label `{span.text}`", hint)


def unknown_mode(span: Span, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown mode of `override`."""
    hint = near_or_all(span.text, candidates, "the modes are")
    return error("E0467", span, f"unknown mode `{span.text}` of `override`", hint)


def override_of_itself(span: Span, label: str) -> Diagnostic:
    """`override(a, a)`."""
    return error("E0468", span, f"`{label}` cannot override itself")


def misplaced_member(span: Span, word: str, name: str, kind: str) -> Diagnostic:
    """A member that only scenarios and actions have (7.2.2.2.6)."""
    return error("E0469", span, f"`{word}` belongs to scenarios and actions, but `{name}` is {kind}")


def override_declared(span: Span) -> Diagnostic:
    """A modifier named `override`, which would be hidden by that of the language."""
    return error("E0470", span, "the modifier `override` is part of the language", "choose another name")


def lacks_parameter(span: Span, name: str, parameter: str, found: str, used: Span) -> Diagnostic:
    """A modifier without `of` that uses a missing parameter of the modified behavior (7.3.12.1.2)."""
    hint = f"`{parameter}` is a parameter of `parallel`"
    if parameter == "duration":
        hint = "compositions have it, and invocations of behaviors without a parameter of that name"
    text = f"`{name}` uses `it.{parameter}`, which {found} does not have"
    return error("E0471", span, text, hint, other=used, remark="used here")
