"""Patterns of statements in other languages, with the equivalent in OpenSCENARIO DSL.

`habit_search.py` joins the words of a statement by single blanks and matches the text against `HABITS`, in order.
If a habit has a repair, parsing continues with it, so that the rest of the statement and its block are checked.
"""

from __future__ import annotations

from typing import Final

from seoro.lang.expression_habits import BEHAVIORS, EXPRESSION_HABITS, FILE, MEMBERS, REACTIONS, Habit
from seoro.lang.habits import NO_IF

_TOP: Final = (
    *("import", "namespace", "export", "unit", "enum", "struct", "actor", "action", "scenario", "modifier"),
    *("extend", "global"),
)
_MEMBERS: Final = ("event", "var", "def", "keep", "remove_default", "cover", "record", "do")
_COMPOSITIONS: Final = ("serial", "parallel", "one_of")
_STEPS: Final = ("wait", "emit", "call", "do", *_COMPOSITIONS)
_CHANGES: Final = (
    "change a variable by `increment({name})` or `decrement({name})` of `import osc.helpers`, or by events: "
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
        "missing composition after `do`",
        "write the composition on the same line: `do serial:`",
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
        "`{at}` is not a statement of OpenSCENARIO DSL",
        NO_IF,
        tails=("else", "elif", "case", "default"),
    ),
    Habit(
        r"(?P<at>for|foreach|while|loop)\b(?! [.=]| : [^\n])",
        "`{at}` is not a statement of OpenSCENARIO DSL",
        "repeat a behavior with `repeat(<count>)` below its `with:`, and end it there by `until <event>`",
        tails=("else",),
    ),
    Habit(
        r"(?P<at>try|except|catch|finally|throw|raise)\b(?! [.=]| : [^\n])",
        "`{at}` is not a statement of OpenSCENARIO DSL",
        "a failure ends the scenario; use `retry()` or `failure_is_success()` of `osc.helpers` below `with:`",
        tails=("except", "catch", "finally", "else"),
    ),
    Habit(
        r"(?P<at>return|pass|break|continue|goto|yield|await|del)\b(?! [.=:(])",
        "`{at}` is not a statement of OpenSCENARIO DSL",
        "a behavior ends with its last member; `emit end` ends the scenario, `until` below `with:` one behavior",
    ),
    Habit(
        r"(?P<at>repeat|retry|timeout|inverter) \( .*: \n",
        "`{at}` opens no block",
        "write a modifier below the `with:` of a behavior: `with:`, and `{at}(...)` in its block",
    ),
    # ------------------------------------------------------------ declarations of other languages
    Habit(
        r"(?P<at>class|interface|record|object)\b(?= \w)",
        "`{at}` is not a statement of OpenSCENARIO DSL",
        "declare a `struct` for values, or an `actor` for something that acts",
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
        "unexpected parameters after the name",
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
        "write the condition of a subtype as an equation: `({field} == {value})`",
        "==",
        FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?P<at>=) \[",
        "unexpected `=` after `{name}`",
        "write `enum {name}: [...]`",
        ":",
        FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?::|=) (?P<at>\w+)",
        "missing brackets around the members of `{name}`",
        "write `enum {name}: [{at}, ...]`, on one line or within the brackets",
        place=FILE,
    ),
    Habit(
        r"enum (?P<name>\w+) (?P<at>:) \n",
        "missing brackets around the members of `{name}`",
        "write `enum {name}: [<member>, <member>]`, on one line or within the brackets",
        place=FILE,
    ),
    Habit(
        r"(?P<at>from (?P<library>osc) import (?P<name>\w+)) \n",
        "unsupported import statement `from ... import`",
        "write `import {library}.{name}`",
        "import {library} . {name}",
        FILE,
    ),
    Habit(
        r"(?P<at>from (?P<library>\w+(?: \. \w+)*) import .*?) \n",
        "unsupported import statement `from ... import`",
        "write `import {library}`, which imports all that the library exports",
        "import {library}",
        FILE,
    ),
    Habit(
        r"import [\w.\" ]+ (?P<at>as \w+) \n",
        "an import has no `as`",
        "omit it: names of a library are used unchanged",
        "",
        FILE,
    ),
    Habit(
        r"import [\w.\" ]+ (?P<at>, .*?) \n",
        "several libraries in one import",
        "write one `import` per line",
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
        "`{at}` is not a statement of OpenSCENARIO DSL",
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
        "expected the type after the name",
        "write `{name}: {type}`",
        "{name} : {type}",
        MEMBERS,
    ),
    Habit(
        r"(?P<at>let|const|val|auto|param|parameter|field|static|final)\b(?= \w)",
        "`{at}` is not a statement of OpenSCENARIO DSL",
        "declare a parameter by `<name>: <type> = <default>`, a variable by `var <name>: <type> = <value>`",
        place=MEMBERS,
    ),
    Habit(
        r"(?:var )?(?P<at>(?P<name>\w+)) (?:: )?= (?P<value>\S+)",
        "missing type of `{name}`",
        "write `{name}: <type> = {value}`",
        place=MEMBERS,
    ),
    Habit(
        r"(?P<at>keep|cover|record|remove_default) (?!\()(?P<rest>.*?) \n",
        "missing `(` after `{at}`",
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
        "write the members of a composition as lines of its block, without dashes",
        "",
        BEHAVIORS,
    ),
    Habit(
        r"emit (?P<at>@)",
        "unexpected `@` after `emit`",
        "emit an event by its name only; use `@` to wait for events, as in `wait @<event>`",
        "",
    ),
    Habit(
        r"wait (?P<at>for (?P<time>\d\S*)) \n",
        "unexpected `for` after `wait`",
        "write `wait elapsed({time})`",
        "elapsed ( {time} )",
    ),
    Habit(
        r"wait (?P<at>until|for|while) .*",
        "unexpected `{at}` after `wait`",
        "write a condition or an event directly after `wait`: `wait <condition>`, `wait @<event>`",
        "",
    ),
    Habit(
        r"(?P<word>wait|emit|call) .*(?P<at>with) : \n",
        "`{word}` takes no `with:`",
        "put the `{word}` into a `serial:` that has the `with:`",
    ),
    Habit(
        r".*\) (?P<at>with) \w+ \(.*\) \n",
        "missing block after `with`",
        "write `with:`, and the modifier or constraint on a line of its own below it",
        place=BEHAVIORS,
    ),
    Habit(
        r"(?P<at>with) : \n",
        "`with:` among the members of a composition",
        "write it at the end of the modified line, or below a block, at the indentation of its first line",
        place=BEHAVIORS,
    ),
    Habit(
        r"(?P<at>assert|check|expect|require|ensure) (?=\w)",
        "`{at}` is not a statement of OpenSCENARIO DSL",
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
        "`{at}` is not a statement of OpenSCENARIO DSL",
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
        "missing `(` after `{name}`",
        "write arguments in brackets: `{name}(...)`",
        place=BEHAVIORS,
    ),
    Habit(
        r"do (?:\w+ : )?(?P<name>\w+(?: \. \w+)*) (?P<at>\"[^\n]*|\d[^\n]*) \n",
        "missing `(` after `{name}`",
        "write arguments in brackets: `{name}(...)`",
    ),
    Habit(
        r"(?:do )?(?:\w+ : )?(?P<name>(?:\w+ \. )+(?P<at>\w+)) \n",
        "missing `()` after `{name}`",
        "an invocation has brackets, also without arguments: `{name}()`",
        "{at} ( )",
    ),
    Habit(
        r"(?P<at>\w+)(?: \. \w+)* \(",
        "`{at}` among reactions",
        "the block of `on` allows only `emit` and `call`; other behavior waits for the event below `do`",
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
        "write `serial`, `parallel` or `one_of`; after a label, write its behavior on the same line",
    ),
)
