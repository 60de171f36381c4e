"""Rules of plain prose. Each yields the sentences of a paragraph that break it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

from tests.tools.prose.texts import Kind, Text

LONGEST = 30  # words of a sentence


class Finding(NamedTuple):
    """A breach of a rule."""

    text: Text
    rule: str
    found: str


_QUESTION = re.compile(
    r"(?:(?:For|From|In|On|At|By|To|Of|With|As) )?"
    r"\b(What|Who|Whom|Whose|Which|Where|When|Why|How|Whether|That)\b",
    re.I,
)
_NONE = re.compile(
    r"\b(?:is|are|was|were|be) (?:no|none)\b(?! (?:longer|more|less)\b)|\bthere (?:is|are) not\b", re.I
)
_SAID = re.compile(
    r"\b(?:tell|tells|told|telling|hear|hears|heard|says?|saying|(?:is|are|was|were|been|be) said)\b", re.I
)
_NAMELESS = re.compile(
    r"\b(?:whoever|whatever|whichever|somebody|nobody|anybody|everybody|(?:those|one|all|they) who)\b", re.I
)
_VAGUE = re.compile(
    r"\bthose that\b"
    r"|\bwhat (?:it|they|he|is|are|was|were|has|have|had|there|others?|another|comes?|came|happens|happened)\b",
    re.I,
)
_END = re.compile(r"(?<=[.!?])[\"')*]*\s+(?=[A-Z0-9\"'(*]|x\b)")
_CODE = re.compile(r"``.*?``|`[^`]*`")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")


def plain(text: str) -> str:
    """Replace code by one word each, and links by their texts."""
    return _CODE.sub("x", _LINK.sub(r"\1", text))


def sentences(text: str) -> list[str]:
    """Split prose into sentences; a colon, a semicolon and a dash do not end one."""
    return [part for part in _END.split(plain(text)) if part]


def question_openings(text: Text) -> Iterator[str]:
    """A paragraph opens with a question word, but asks nothing; `Whether` may describe booleans."""
    first = next(iter(sentences(text.text)), "")
    if first.rstrip().endswith("?"):
        return
    match = _QUESTION.match(first)
    if match is None or (text.kind is Kind.STRING and not first[0].isupper()):
        return
    word = match.group(1).lower()
    if word == "whether" and text.kind is not Kind.DOCSTRING:
        return
    if word in ("when", "where", "how") and text.kind in (Kind.PAGE, Kind.COMMENT):
        return
    if word == "that" and text.kind is Kind.COMMENT:
        return
    yield first


def negations(text: Text) -> Iterator[str]:
    """`is no`, `is none`, `there is not`, where `invalid`, `missing`, `unknown` or a negated verb is meant."""
    for sentence in sentences(text.text):
        if _NONE.search(sentence):
            yield sentence


def sayings(text: Text) -> Iterator[str]:
    """`tell`, `hear`, `say`, where something is reported, printed, sent, returned or received."""
    for sentence in sentences(text.text):
        if _SAID.search(sentence):
            yield sentence


def vague_subjects(text: Text) -> Iterator[str]:
    """`whoever`, `somebody`, and in code `those that` and `what is`, where the subject has a name."""
    for sentence in sentences(text.text):
        if _NAMELESS.search(sentence) or (text.kind is not Kind.PAGE and _VAGUE.search(sentence)):
            yield sentence


def long_sentences(text: Text) -> Iterator[str]:
    """A sentence has more than `LONGEST` words."""
    for sentence in sentences(text.text):
        if len(re.findall(r"[\w'/-]+", sentence)) > LONGEST:
            yield sentence


RULES: dict[str, Callable[[Text], Iterator[str]]] = {
    "question": question_openings,
    "negation": negations,
    "saying": sayings,
    "vague": vague_subjects,
    "long": long_sentences,
}


def check(text: Text) -> Iterator[Finding]:
    """Yield what breaks a rule in a paragraph."""
    for name, rule in RULES.items():
        for found in rule(text):
            yield Finding(text, name, found)
