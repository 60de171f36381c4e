"""Messages of libraries and external methods whose Python does not match (E0601 to E0612)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error, warning
from seoro.lang.diagnostics import near
from seoro.lang.source import Span

ONLY_DECLARED = "E0612"


def broken_module(span: Span, library: str, module: str, reason: str, hint: str) -> Diagnostic:
    """The Python module of a library raises when it is imported."""
    return error("E0601", span, f"cannot import the Python module `{module}` of `{library}`: {reason}", hint)


def no_implementation(span: Span, library: str, declared: str, expected: str) -> Diagnostic:
    """A library that declares actions or modifiers without a Python module."""
    text = f"`{library}` declares {declared}, but has no Python module that implements it"
    hint = f"write the module `{expected}` beside the declarations"
    return error("E0602", span, text, hint)


def undeclared(
    span: Span, library: str, function: str, kind: str, name: str, candidates: tuple[str, ...]
) -> Diagnostic:
    """A Python function that implements something its library does not declare."""
    text = f"`{function}` implements the {kind} `{name}`, which `{library}` does not declare"
    hint = near(name, candidates) or f"declare it in the `.osc` file, or remove `@{kind}`"
    return error("E0603", span, text, hint)


def implementation_mismatch(
    span: Span, function: str, kind: str, name: str, reason: str, expected: str
) -> Diagnostic:
    """A Python function that does not match the declaration of its action or modifier."""
    text = f"`{function}` does not match the {kind} `{name}`: {reason}"
    return error("E0604", span, text, f"expected `{expected}`" if expected else "")


def several_implementations(span: Span, kind: str, name: str, functions: tuple[str, str]) -> Diagnostic:
    """Several Python functions for one action or modifier."""
    hint = "rename one of them, and declare the new name"
    return error("E0605", span, f"both `{functions[0]}` and `{functions[1]}` implement the {kind} `{name}`", hint)


def missing_module(span: Span, path: str, module: str, folder: str = "") -> Diagnostic:
    """An external method of a missing Python module; `folder` has its package as source."""
    if folder:
        hint = f"`{folder}` has its package: install it beside seoro, with `pip install {folder}`"
        return error("E0606", span, f"Python module `{module}` of `{path}` not found", hint)
    hint = "install it, or put it beside this file or into the package of its library"
    return error("E0606", span, f"Python module `{module}` of `{path}` not found", hint)


def missing_function(span: Span, path: str, holder: str, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """An external method of a Python module without the function."""
    hint = near(name, candidates)
    return error("E0607", span, f"Python function `{path}` not found: `{holder}` has no `{name}`", hint)


def broken_function(span: Span, path: str, module: str, reason: str, hint: str) -> Diagnostic:
    """The Python module of an external method raises when it is imported."""
    return error("E0608", span, f"cannot import the Python module `{module}` of `{path}`: {reason}", hint)


def method_signature_mismatch(span: Span, path: str, method: str, reason: str) -> Diagnostic:
    """A Python function that does not match the external method it implements."""
    return error("E0609", span, f"`{path}` does not match the method `{method}`: {reason}")


def plain_function(span: Span, function: str, name: str) -> Diagnostic:
    """A plain function without `thread=True` that implements an action."""
    hint = f'make it `async def`, or run it in a thread: `@action("{name}", thread=True)`'
    return error("E0610", span, f"`{function}` implements the action `{name}`, but is not `async`", hint)


def async_in_thread(span: Span, function: str, name: str) -> Diagnostic:
    """An `async` function with `thread=True` that implements an action."""
    text = f"`{function}` implements the action `{name}` with `thread=True`, but is `async`"
    hint = "make it a plain `def`, or remove `thread=True`: an `async` function needs no thread"
    return error("E0611", span, text, hint)


def only_declared(span: Span, name: str, library: str, hint: str) -> Diagnostic:
    """An invocation of an action that a library of seoro only declares, without a package that implements it."""
    return warning(
        ONLY_DECLARED, span, f"`{library}` only declares the action `{name}`; the run will be refused", hint
    )
