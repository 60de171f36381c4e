"""Statements as they are written in other languages: patterns of words, and what to write here.

`habit_search.py` lays a statement out as its words with one blank between them and compares it with `HABITS`, in
order. Some habits have a repair, with which parsing goes on, so that the rest of the statement and its block are
checked.
"""

from __future__ import annotations

from typing import Final

from seoro.lang.expression_habits import EXPRESSION_HABITS
from seoro.lang.habit import BEHAVIORS, FILE, MEMBERS, REACTIONS, Habit

_TOP: Final = (
    *("import", "namespace", "export", "unit", "enum", "struct", "actor", "action", "scenario", "modifier"),
    *("extend", "global"),
)
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
        r"(?P<at>if|elif|else|switch|case|match|unless|select|when)\b(?! [.=]| : [^\n])",
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
        "a behavior ends with its last member; `emit end` ends the scenario, `until` below `with:` one behavior",
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
        "write `def <name>(<name>: <type>) -> <type> is expression <value>` in a type; behavior is a `scenario`",
        place=FILE,
    ),
    Habit(
        r"def .*(?P<at>:) \n \t",
        "a method has no block",
        "a method is one expression: `def <name>(<name>: <type>) -> <type> is expression <value>`",
        place=MEMBERS,
    ),
    Habit(
        r"def .*\) (?:-> .+ )?(?P<at>=) (?P<value>.+) \n",
        "unexpected `=` in a method",
        "write `is expression {value}`",
        "is expression",
        MEMBERS,
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
        r"import (?P<library>\w+(?: \. \w+)+) (?P<at>\. \*)",
        "an import has no `*`",
        "write `import {library}`, which imports all that the library exports",
        "",
        FILE,
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
        r"keep \( (?P<at>soft) .*",
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
        r"wait (?P<at>until|for|while) .*",
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
        r".*\) (?P<at>with) \w+ \(.*\) \n",
        "missing block behind `with`",
        "write `with:`, and the modifier or constraint on a line of its own below it",
        place=BEHAVIORS,
    ),
    Habit(
        r"(?P<at>with) : \n",
        "`with:` among the members of a composition",
        "write it at the end of the line of what it modifies, or below a block, as far left as its first line",
        place=BEHAVIORS,
    ),
    Habit(
        r"(?P<at>assert|check|expect|require|ensure) (?=\w)",
        "the language has no `{at}`",
        "write `wait <condition>`, with a `timeout` below `with:`",
        place=BEHAVIORS,
    ),
    Habit(
        r"(?P<at>(?P<name>\w+) : \w+(?: \w+)*) = ",
        "declaration of `{name}` within `do`",
        "declare it among the members of the scenario, outside of `do`",
        place=BEHAVIORS,
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
        r"(?:do )?(?:\w+ : )?(?P<name>(?!wait |emit |call |do )\w+(?: \. \w+)*) (?:: )?(?P<at>[\"\d][^\n]*) \n",
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
    *EXPRESSION_HABITS,
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
        "write `serial`, `parallel` or `one_of`; a label is followed by what it names on the same line",
    ),
)
