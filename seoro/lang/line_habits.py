"""Statements as they are written in other languages: patterns of words, and what to write here.

A statement that cannot be parsed is laid out as its words with one blank between them and compared with `HABITS`, in
order. The first pattern that includes the word at fault gives the message. Some habits have a repair: parsing goes on
with the repaired statement, so that the rest of it and its block are checked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Final

from seoro.lang.diagnostics import listing, syntax
from seoro.lang.frozen import Frozen
from seoro.lang.lexer import Token
from seoro.lang.source import SourceFile, Span

END: Final = "\n"  # of a line, in the layout of a statement
BLOCK: Final = "\t"  # the beginning of a block
FILE, MEMBERS, BEHAVIORS, REACTIONS = "file", "members", "behaviors", "reactions"  # where statements stand
_TOP: Final = ("import", "namespace", "export", "unit", "enum", "struct", "actor", "action", "scenario", "modifier",
               "extend", "global")  # fmt: skip
_MEMBERS: Final = ("event", "var", "def", "keep", "remove_default", "cover", "record", "do")
_COMPOSITIONS: Final = ("serial", "parallel", "one_of")
_STEPS: Final = ("wait", "emit", "call", "do", *_COMPOSITIONS)
_INSTEAD_OF_IF: Final = (
    "use `one_of` with a `wait <condition>` in each branch, `on <event>:`, or `? :` in an expression"
)
_CHANGES: Final = (
    "variables change by `increment({name})` and `decrement({name})` of `import osc.helpers`, or with events: "
    "`var {name}: <type> = sample(<value>, @<event>, <first value>)`"
)


class Habit(Frozen):
    """A statement as another language has it.

    Args:
        pattern: A regular expression for the words of a statement. Its group `at` is what is at fault.
        message: The message; names of groups in braces stand for what they matched.
        help: How to repair it.
        repair: The words that replace `at`; None if the statement is skipped.
        place: Where statements of this kind stand; empty for everywhere.
        meant: What `at` may be a misspelling of, for `{meant}`; the habit is passed over if nothing comes near.
        tails: Words with which further parts of the same statement begin, which are skipped with it.
    """

    pattern: str
    message: str
    help: str
    repair: str | None = None
    place: str = ""
    meant: tuple[str, ...] = ()
    tails: tuple[str, ...] = ()


HABITS: Final = (
    # ------------------------------------------------------------ compositions
    Habit(
        r"(?P<at>serial|parallel|one_of) [:(]",
        "`{at}` outside of `do`",
        "write `do {at}:`",
        "do {at}",
        MEMBERS,
    ),
    Habit(
        r"do (?:\w+ : )?(?P<at>:) \n",
        "missing composition behind `do`",
        "`do` is followed by what it does on the same line: `do serial:`",
        "serial :",
    ),
    Habit(
        r"(?:do )?(?:\w+ : )?(?P<at>\w+) (?:\( .*)?: \n \t",
        "unknown composition `{at}`",
        "did you mean {meant}?",
        "{only}",
        "",
        _COMPOSITIONS,
    ),
    # ------------------------------------------------------------ control flow
    Habit(
        r"(?P<at>if|elif|else|switch|case|match|unless|select)\b(?! [.=]| : [^\n])",
        "the language has no `{at}`",
        _INSTEAD_OF_IF,
        tails=("else", "elif", "case", "default"),
    ),
    Habit(
        r"(?P<at>for|foreach|while|loop)\b(?! [.=]| : [^\n])",
        "the language has no `{at}`",
        "repeat a behavior with `repeat(<count>)` below its `with:`, and end it there by `until <event>`",
        tails=("else",),
    ),
    Habit(
        r"(?P<at>try|except|catch|finally|throw|raise)\b(?! [.=]| : [^\n])",
        "the language has no `{at}`",
        "what fails ends the scenario; `retry()` and `failure_is_success()` of `osc.helpers` stand below `with:`",
        tails=("except", "catch", "finally", "else"),
    ),
    Habit(
        r"(?P<at>return|pass|break|continue|goto|yield|await|del)\b(?! [.=:(])",
        "the language has no `{at}`",
        "a behavior ends with its last member; `emit end` ends the scenario, and `until` below `with:` one behavior",
    ),
    Habit(
        r"(?P<at>repeat|retry|timeout|inverter) \( .*: \n",
        "`{at}` opens no block",
        "modifiers stand below the `with:` of what they modify: `with:`, and `{at}(...)` in its block",
    ),
    # ------------------------------------------------------------ declarations of other languages
    Habit(
        r"(?P<at>class|interface|record|object)\b(?= \w)",
        "the language has no `{at}`",
        "declare a `struct` for values, or an `actor` for what acts",
        place=FILE,
    ),
    Habit(
        r"(?P<at>def|function|fn|func)\b(?= \w+ \()",
        "`{at}` outside of a type",
        "methods are members: `def <name>(<name>: <type>) -> <type> is expression <value>`; behavior is a `scenario`",
        place=FILE,
    ),
    Habit(
        r"def .*(?P<at>:) \n \t",
        "a method has no block",
        "a method is one expression: `def <name>(<name>: <type>) -> <type> is expression <value>`",
        place=MEMBERS,
    ),
    Habit(
        r"(?:scenario|action|actor|struct|modifier) \w+(?: \. \w+)? (?P<at>\() (?:\w+ :.*)?\)",
        "parameters in brackets behind the name",
        "declare them as members, one on each line of the block: `<name>: <type> = <default>`",
        place=FILE,
    ),
    Habit(
        r"(?:struct|actor|scenario|action) \w+(?: \. \w+)? (?P<at>(?:\( |: |(?:extends|is|of|from) )"
        r"(?P<base>\w+(?: \. \w+)?)(?: \))?)(?= :| \n)",
        "unknown inheritance `{at}`",
        "write `inherits {base}`",
        "inherits {base}",
        FILE,
    ),
    Habit(
        r"\w+ \w+ inherits .*\( (?P<field>\w+) (?P<at>:|=) (?P<value>\w+)",
        "unexpected `{at}` in the condition",
        "the condition of a subtype is an equation: `({field} == {value})`",
        "==",
        FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?P<at>=) \[",
        "unexpected `=` behind `{name}`",
        "write `enum {name}: [...]`",
        ":",
        FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?::|=) (?P<at>\w+)",
        "the members of `{name}` lack their brackets",
        "write `enum {name}: [{at}, ...]`, on one line or within the brackets",
        place=FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?P<at>:) \n",
        "the members of `{name}` lack their brackets",
        "write `enum {name}: [<member>, <member>]`, on one line or within the brackets",
        place=FILE,
    ),
    Habit(
        r"(?P<at>from (?P<library>osc) import (?P<name>\w+)) \n",
        "unknown import statement `from ... import`",
        "write `import {library}.{name}`",
        "import {library} . {name}",
        FILE,
    ),
    Habit(
        r"(?P<at>from (?P<library>\w+(?: \. \w+)*) import .*?) \n",
        "unknown import statement `from ... import`",
        "write `import {library}`, which imports all that the library exports",
        "import {library}",
        FILE,
    ),
    Habit(
        r"import [\w.\" ]+ (?P<at>as \w+) \n",
        "an import has no `as`",
        "leave it out: names of a library are used as they are",
        "",
        FILE,
    ),
    Habit(
        r"import [\w.\" ]+ (?P<at>, .*?) \n",
        "several libraries in one import",
        "write one `import` a line",
        place=FILE,
    ),
    Habit(
        r"(?P<at>include|using|require|use|load)(?= [\w\"])",
        "the language has no `{at}`",
        'write `import osc.<library>`, or `import "<file>.osc"`',
        "import",
        FILE,
    ),
    Habit(
        r"(?P<at>@) .*\n",
        "unexpected decorator",
        "remove it: directives for tests are comments, such as `# seoro: timeout=60`",
        place=FILE,
    ),
    # ------------------------------------------------------------ fields and constraints
    Habit(
        r"(?P<at>(?P<type>int|uint|float|bool|string|double) (?P<name>\w+)) (?:=|\n)",
        "the type stands in front of the name",
        "write `{name}: {type}`",
        "{name} : {type}",
        MEMBERS,
    ),
    Habit(
        r"(?P<at>let|const|val|auto|param|parameter|field|static|final)\b(?= \w)",
        "the language has no `{at}`",
        "a parameter is declared by `<name>: <type> = <default>`, a variable by `var <name>: <type> = <value>`",
        place=MEMBERS,
    ),
    Habit(
        r"(?:var )?(?P<at>(?P<name>\w+)) (?:: )?= (?P<value>\S+)",
        "`{name}` lacks its type",
        "write `{name}: <type> = {value}`",
        place=MEMBERS,
    ),
    Habit(
        r"(?P<at>keep|cover|record|remove_default) (?!\()(?P<rest>.*?) \n",
        "missing `(` behind `{at}`",
        "write `{at}({rest})`",
        "{at} ( {rest} )",
    ),
    Habit(
        r"keep \( (?P<at>soft)\b",
        "unknown constraint qualifier `soft`",
        "write `default`: `keep(default ...)`",
        "default",
    ),
    # ------------------------------------------------------------ steps of a behavior
    Habit(
        r"(?P<at>-)(?= \w)",
        "unexpected `-` before a member",
        "members of a composition are lines of its block, without dashes",
        "",
        BEHAVIORS,
    ),
    Habit(
        r"emit (?P<at>@)",
        "unexpected `@` behind `emit`",
        "an event is emitted by its name alone; `@` is for what listens, as in `wait @<event>`",
        "",
    ),
    Habit(
        r"wait (?P<at>for (?P<time>\d\S*)) \n",
        "unexpected `for` behind `wait`",
        "write `wait elapsed({time})`",
        "elapsed ( {time} )",
    ),
    Habit(
        r"wait (?P<at>until|for|while)\b(?= )",
        "unexpected `{at}` behind `wait`",
        "a condition or an event stands directly behind `wait`: `wait <condition>`, `wait @<event>`",
        "",
    ),
    Habit(
        r"(?P<word>wait|emit|call) .*(?P<at>with) : \n",
        "`{word}` takes no `with:`",
        "put it below a `serial:` around the `{word}` that has the `with:`",
    ),
    Habit(
        r"(?:do )?(?P<at>set|let|assign) (?P<name>\w+(?: \. \w+)*) (?::|to|=)",
        "the language has no `{at}`",
        _CHANGES,
        place=BEHAVIORS,
    ),
    Habit(
        r"(?:do )?(?P<name>\w+(?: \. \w+)*) (?P<at>=|: =|[-+*/] =|\+ \+|- -)",
        "`{name}` cannot be assigned to",
        _CHANGES,
        place=BEHAVIORS,
    ),
    Habit(
        r"(?:do )?(?:\w+ : )?(?P<name>(?!wait |emit |call |do )\w+(?: \. \w+)*) (?:: )?(?P<at>\"[^\n]*|\d[^\n]*) \n",
        "missing `(` behind `{name}`",
        "arguments stand in brackets: `{name}(...)`",
        place=BEHAVIORS,
    ),
    Habit(
        r"do (?:\w+ : )?(?P<name>\w+(?: \. \w+)*) (?P<at>\"[^\n]*|\d[^\n]*) \n",
        "missing `(` behind `{name}`",
        "arguments stand in brackets: `{name}(...)`",
    ),
    Habit(
        r"(?:do )?(?:\w+ : )?(?P<name>(?:\w+ \. )+(?P<at>\w+)) \n",
        "missing `()` behind `{name}`",
        "what is invoked has brackets, also without arguments: `{name}()`",
        "{at} ( )",
    ),
    Habit(
        r"(?P<at>\w+)(?: \. \w+)* \(",
        "`{at}` among reactions",
        "the block of `on` has `emit` and `call` only; other behavior waits for the event below `do`",
        place=REACTIONS,
    ),
    # ------------------------------------------------------------ expressions
    Habit(
        r".*?(?P<at>!) (?!=)",
        "unexpected `!`",
        "the negation is written `not`; behind the name of an enumeration, `!` takes a member",
        "not",
    ),
    Habit(
        r".*?(?P<number>\d[\d.]*) (?P<at>%) (?:[,)\]\n]|with)",
        "`%` is the remainder and needs a right side",
        "{number} percent is `{percent}`",
        "",
    ),
    Habit(
        r".+?(?P<at>if) .+ else .+",
        "unexpected `if` in an expression",
        "the conditional expression is `<condition> ? <value> : <value>`",
    ),
    Habit(r".+?(?P<at>\* \*)", "unknown operator `**`", "powers are written as products: `a * a`"),
    Habit(r".+?(?P<at>/ /)", "unknown operator `//`", "the quotient is written `/`"),
    Habit(r".+?(?P<at>is not)\b", "unknown operator `is not`", "write `!=`", "! ="),
    Habit(r".+?(?P<at>not in)\b", "unknown operator `not in`", "write `not (<value> in <list>)`"),
    Habit(r".+?(?P<at>->) (?=\w)", "unexpected `->`", "members are taken by `.`", "."),
    Habit(
        r".+?(?P<at>= = =|= = )",
        "unknown operator `===`",
        "values are compared by `==`",
    ),
    # ------------------------------------------------------------ misspelled keywords
    Habit(
        r"(?P<at>\w+) (?=[\w\"])",
        "unknown keyword `{at}`",
        "did you mean {meant}?",
        "{only}",
        FILE,
        _TOP,
    ),
    Habit(
        r"(?P<at>\w+) (?=[\w@(])",
        "unknown keyword `{at}`",
        "did you mean {meant}?",
        "{only}",
        MEMBERS,
        _MEMBERS,
    ),
    Habit(
        r"(?P<at>\w+) (?=[\w@])",
        "unknown keyword `{at}`",
        "did you mean {meant}?",
        "{only}",
        BEHAVIORS,
        _STEPS,
    ),
    Habit(
        r"do (?P<at>\w+) : \n",
        "unknown composition `{at}`",
        "the compositions are `serial`, `parallel` and `one_of`; a label is followed by what it names on the same line",
    ),
)


class Found(Frozen):
    """A habit that was found in a statement.

    Args:
        habit: The habit.
        message: Its message.
        first: The index of the first token at fault.
        behind: The index behind the last one.
        repair: The text to read in their place; None if the statement is skipped.
    """

    habit: Habit
    message: syntax.OtherLanguage
    first: int
    behind: int
    repair: str | None


def find(
    file: SourceFile, tokens: Sequence[Token], first: int, index: int, stands: Callable[[str], bool]
) -> Found | None:
    """The habit that a statement shows; None if it shows none.

    Args:
        file: The text.
        tokens: Its tokens.
        first: The index of the first token of the statement.
        index: The index of the token that does not fit.
        stands: Whether the statement stands in a place.
    """
    words, starts = _lay_out(file, tokens, first)
    at_fault = starts[index - first]
    for habit in HABITS:
        found = _pattern(habit).match(words)
        if found is None or not _concerns(found, habit, at_fault, index - first) or not stands(habit.place):
            continue
        near = _near(found["at"], habit.meant)
        if habit.meant and (not near or found["at"] in habit.meant):
            continue
        start = starts.index(found.start("at"))
        behind = next((number for number, offset in enumerate(starts) if offset >= found.end("at")), len(starts))
        span = Span(file, tokens[first + start].start, tokens[first + behind - 1].end)
        fields = {name: _joined(text) for name, text in found.groupdict().items() if text is not None}
        fields |= {"meant": listing(near, "or"), "only": near[0] if near else "", "at": span.text}
        if "number" in fields:
            fields["percent"] = f"{float(fields['number']) / 100:g}"
        message = syntax.OtherLanguage(span, habit.message.format(**fields), habit.help.format(**fields))
        repair = habit.repair.format(**fields) if habit.repair is not None else None
        return Found(habit, message, first + start, first + behind, repair)
    return None


def _concerns(found: re.Match[str], habit: Habit, at_fault: int, number: int) -> bool:
    """Whether a habit explains the word at an offset, the `number`-th of the statement from 0."""
    if found.end() > at_fault:
        return True
    return found.start("at") == 0 and (not habit.meant or number <= 1)


def _lay_out(file: SourceFile, tokens: Sequence[Token], first: int) -> tuple[str, list[int]]:
    """The words of a statement with one blank between them, and where each of them begins."""
    parts: list[str] = []
    starts: list[int] = []
    offset = 0
    for token in tokens[first:]:
        if token.kind in {"_NEWLINE", "_INDENT", "_DEDENT", "$END"}:
            text = BLOCK if token.kind == "_INDENT" else END
        else:
            text = file.text[token.start : token.end] if token.kind != "STRING_LITERAL" else '"'
        is_end = token.kind in {"_DEDENT", "$END", "_INDENT"} and bool(parts)
        if is_end and token.kind != "_INDENT":
            break
        parts.append(text)
        starts.append(offset)
        offset += len(text) + 1
        if is_end:
            break
        if token.kind == "_NEWLINE":
            following = tokens[first + len(parts)]
            if following.kind != "_INDENT":
                break
    return " ".join(parts) + " ", starts


def _near(word: str, meant: Sequence[str]) -> list[str]:
    """What a word may be a misspelling of."""
    if word.lower() in meant:
        return [word.lower()]
    return get_close_matches(word.lower(), meant, n=2, cutoff=0.7)


def _joined(words: str) -> str:
    """Words of a statement as they are written."""
    return re.sub(r" ?([.()]) ?", r"\1", words)


@cache
def _pattern(habit: Habit) -> re.Pattern[str]:
    return re.compile(habit.pattern)
