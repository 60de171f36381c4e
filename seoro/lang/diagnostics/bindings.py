"""Messages of libraries and external methods whose Python does not match (E0601 to E0611)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage


class BrokenModule(TemplateMessage):
    """The Python module of a library raises when it is imported."""

    CODE = "E0601"
    TEXT = "cannot import the Python module `{module}` of `{library}`: {reason}"
    HELP = "{hint}"

    library: str
    module: str
    reason: str
    hint: str


class NoImplementation(TemplateMessage):
    """A library that declares actions or modifiers without a Python module."""

    CODE = "E0602"
    TEXT = "`{library}` declares {declared}, but has no Python module that implements it"
    HELP = "write the module `{expected}` beside the declarations"

    library: str
    declared: str
    expected: str


class Undeclared(TemplateMessage):
    """A Python function that implements something its library does not declare."""

    CODE = "E0603"
    TEXT = "`{function}` implements the {kind} `{name}`, which `{library}` does not declare"
    HELP = ("{near}", "declare it in the `.osc` file, or remove `@{kind}`")

    library: str
    function: str
    kind: str
    name: str
    candidates: tuple[str, ...]


class ImplementationMismatch(TemplateMessage):
    """A Python function that does not match the declaration of its action or modifier."""

    CODE = "E0604"
    TEXT = "`{function}` does not match the {kind} `{name}`: {reason}"
    HELP = ("expected `{expected}`",)

    function: str
    kind: str
    name: str
    reason: str
    expected: str


class SeveralImplementations(TemplateMessage):
    """Several Python functions for one action or modifier."""

    CODE = "E0605"
    TEXT = "both `{functions[0]}` and `{functions[1]}` implement the {kind} `{name}`"
    HELP = "rename one of them, and declare the new name"

    kind: str
    name: str
    functions: tuple[str, str]


class MissingModule(TemplateMessage):
    """An external method of a missing Python module."""

    CODE = "E0606"
    TEXT = "Python module `{module}` of `{path}` not found"
    HELP = "install it, or put it beside this file or into the package of its library"

    path: str
    module: str


class MissingFunction(TemplateMessage):
    """An external method of a Python module without the function."""

    CODE = "E0607"
    TEXT = "Python function `{path}` not found: `{holder}` has no `{name}`"
    HELP = "{near}"

    path: str
    holder: str
    name: str
    candidates: tuple[str, ...]


class BrokenFunction(TemplateMessage):
    """The Python module of an external method raises when it is imported."""

    CODE = "E0608"
    TEXT = "cannot import the Python module `{module}` of `{path}`: {reason}"
    HELP = "{hint}"

    path: str
    module: str
    reason: str
    hint: str


class MethodSignatureMismatch(TemplateMessage):
    """A Python function that does not match the external method it implements."""

    CODE = "E0609"
    TEXT = "`{path}` does not match the method `{method}`: {reason}"

    path: str
    method: str
    reason: str


class PlainFunction(TemplateMessage):
    """A plain function without `thread=True` that implements an action."""

    CODE = "E0610"
    TEXT = "`{function}` implements the action `{name}`, but is not `async`"
    HELP = 'make it `async def`, or run it in a thread: `@action("{name}", thread=True)`'

    function: str
    name: str


class AsyncInThread(TemplateMessage):
    """An `async` function with `thread=True` that implements an action."""

    CODE = "E0611"
    TEXT = "`{function}` implements the action `{name}` with `thread=True`, but is `async`"
    HELP = "make it a plain `def`, or remove `thread=True`: an `async` function needs no thread"

    function: str
    name: str
