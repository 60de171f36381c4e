"""Messages as declarations: a code, templates of the texts, and fields that fill the templates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import Formatter
from typing import Any, ClassVar, TypeAlias

from seoro.lang.diagnostic import MAX_TEXT, Diagnostic, Label, Severity
from seoro.lang.diagnostics import listing, near, with_article
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span

Template: TypeAlias = str | tuple[str, ...]
"""A format string, or alternatives: the first whose fields are all set is used, else the empty text.

Fields are attributes of the message. Additional format specifications: `{type:a}` adds the article, `{names:and}`
and `{names:or}` quote and join names, `{flag:if}` is a condition and shows nothing. `{near}` suggests
`candidates` of the message that resemble its `name`.
"""


class TemplateMessage(Frozen):
    """A message: subclasses declare its code, its templates and its fields."""

    CODE: ClassVar[str]
    SEVERITY: ClassVar[Severity] = Severity.ERROR
    TEXT: ClassVar[Template]
    HELP: ClassVar[Template] = ""
    LABEL: ClassVar[Template] = ""  # at `span`
    OTHERS: ClassVar[tuple[tuple[str, Template], ...]] = ()  # a field with a span (or None), and its label

    span: Span

    def diagnostic(self) -> Diagnostic:
        """Fill the templates."""
        others = [(getattr(self, field), template) for field, template in self.OTHERS]
        return Diagnostic(
            self.SEVERITY,
            self.CODE,
            _fill(self.TEXT, self),
            Label(self.span, _fill(self.LABEL, self)),
            tuple(Label(span, _fill(template, self)) for span, template in others if span is not None),
            _fill(self.HELP, self),
        )


def _fill(template: Template, message: TemplateMessage) -> str:
    """Fill a template; the middle of an overlong text is left out, as names and strings can have any length."""
    text = ""
    for alternative in (template,) if isinstance(template, str) else template:
        try:
            text = _Filler(needs_all=template is not alternative).vformat(alternative, (message,), {})
        except _Unset:
            continue
        break
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT // 2]}...{text[-MAX_TEXT // 2 :]}"


class _Unset(Exception):
    """A field of an alternative has no value."""


class _Filler(Formatter):
    """Fills a template from the attributes of a message."""

    def __init__(self, needs_all: bool) -> None:
        self._needs_all = needs_all

    def get_value(self, key: int | str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
        (message,) = args
        return near(message.name, message.candidates) if key == "near" else getattr(message, str(key))

    def format_field(self, value: Any, format_spec: str) -> str:
        if self._needs_all and not value:
            raise _Unset
        match format_spec:
            case "a":
                return with_article(value)
            case "and" | "or":
                return listing(value, format_spec)
            case "if":
                return ""
        text: str = super().format_field(value, format_spec)
        return text
