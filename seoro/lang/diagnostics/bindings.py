"""Messages of libraries and external methods whose Python does not fit (E0601 to E0611)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class BrokenModule(Frozen):
    """A library whose Python module raises when it is imported."""

    span: Span
    library: str
    module: str
    reason: str
    hint: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"the Python module `{self.module}` of `{self.library}` cannot be imported: {self.reason}"
        return error("E0601", self.span, text, help=self.hint)


class NoImplementation(Frozen):
    """A library that declares actions or modifiers, without a Python module that could carry them out."""

    span: Span
    library: str
    declared: str
    expected: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.library}` declares {self.declared}, and has no Python module to carry it out"
        return error("E0602", self.span, text, help=f"write it as `{self.expected}`, beside the declarations")


class Undeclared(Frozen):
    """A Python function that carries out what its library does not declare."""

    span: Span
    library: str
    function: str
    kind: str
    name: str
    declared: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = (
            f"`{self.function}` carries out the {self.kind} `{self.name}`, which `{self.library}` does not declare"
        )
        hint = near(self.name, self.declared) or f"declare it in the `.osc` file, or take `@{self.kind}` away"
        return error("E0603", self.span, text, help=hint)


class OtherParameters(Frozen):
    """A Python function that does not fit the declaration of the action or modifier that it carries out."""

    span: Span
    function: str
    kind: str
    name: str
    reason: str
    expected: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.function}` cannot carry out the {self.kind} `{self.name}`: {self.reason}"
        hint = f"what fits is `{self.expected}`" if self.expected else ""
        return error("E0604", self.span, text, help=hint)


class SeveralImplementations(Frozen):
    """An action or a modifier that several Python functions carry out."""

    span: Span
    kind: str
    name: str
    functions: tuple[str, str]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        first, second = self.functions
        text = f"both `{first}` and `{second}` carry out the {self.kind} `{self.name}`"
        return error("E0605", self.span, text, help="one of them has to have another name, and a declaration")


class NoPythonModule(Frozen):
    """An external method of a Python module that there is not."""

    span: Span
    path: str
    module: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"there is no Python module `{self.module}` for `{self.path}`"
        hint = "it has to be installed, or to lie beside this file or in the package of its library"
        return error("E0606", self.span, text, help=hint)


class NoPythonFunction(Frozen):
    """An external method whose Python module does not have the function."""

    span: Span
    path: str
    holder: str
    name: str
    known: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"there is no Python function `{self.path}`: `{self.holder}` has no `{self.name}`"
        return error("E0607", self.span, text, help=near(self.name, self.known))


class BrokenFunction(Frozen):
    """An external method whose Python module raises when it is imported."""

    span: Span
    path: str
    module: str
    reason: str
    hint: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"the Python module `{self.module}` of `{self.path}` cannot be imported: {self.reason}"
        return error("E0608", self.span, text, help=self.hint)


class OtherArguments(Frozen):
    """A Python function that does not fit the external method that it implements."""

    span: Span
    path: str
    method: str
    reason: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.path}` cannot be the method `{self.method}`: {self.reason}"
        return error("E0609", self.span, text)


class PlainFunction(Frozen):
    """A plain function that carries out an action, and does not say that it runs in a thread."""

    span: Span
    function: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.function}` carries out the action `{self.name}`, and is not `async`"
        hint = f'make it `async def`, or say `@action("{self.name}", thread=True)`: then it is called in a thread'
        return error("E0610", self.span, text, help=hint)


class AsyncInThread(Frozen):
    """An `async` function that carries out an action, and says that it runs in a thread."""

    span: Span
    function: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.function}` carries out the action `{self.name}` with `thread=True`, and is `async`"
        hint = "make it a plain `def`, or take `thread=True` away: an `async` function needs no thread"
        return error("E0611", self.span, text, help=hint)
