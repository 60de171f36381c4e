"""Lazy elaboration of behaviors, and a cache of their messages between checks of a file.

The messages about the body of a `do` depend on its text, on all text outside of such bodies, and on their labels.
If these are unchanged, so are the messages, and the body is elaborated only if its plan is needed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from seoro.lang import ast, plan
from seoro.lang.check.behaviors import Behaviors
from seoro.lang.check.expressions import Expressions
from seoro.lang.diagnostic import Diagnostic, Label
from seoro.lang.diagnostics import behaviors as behavior_messages
from seoro.lang.loader import Module, Sources
from seoro.lang.program import Program
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import DoFound, TypeSymbol


class ElaboratedBehaviors(Mapping[TypeSymbol, plan.Behavior]):
    """The behavior of each scenario and action that has a valid one.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._made: dict[TypeSymbol, plan.Behavior] = {}
        self._left: list[DoFound] = []

    def add(self, found: DoFound) -> None:
        """Elaborate a behavior now; errors are reported."""
        behavior = Behaviors(found, self._expressions).elaborate()
        if behavior is not None:
            self._made[found.owner] = behavior

    def leave(self, found: DoFound) -> None:
        """Defer a behavior, whose messages are known, until its plan is needed."""
        self._left.append(found)

    def complete(self) -> dict[TypeSymbol, plan.Behavior]:
        """Elaborate the deferred behaviors, and return all."""
        left, self._left = self._left, []
        for found in left:
            self.add(found)
        return self._made

    def __getitem__(self, symbol: TypeSymbol) -> plan.Behavior:
        return self.complete()[symbol]

    def __iter__(self) -> Iterator[TypeSymbol]:
        return iter(self.complete())

    def __len__(self) -> int:
        return len(self.complete())


class _Body(NamedTuple):
    """A checked body: its text, and its messages, with spans relative to its start."""

    text: str
    messages: tuple[Diagnostic, ...]


class BodyMessages:
    """Cached messages about bodies of one scenario file and its imports, from its last valid text."""

    def __init__(self) -> None:
        self._outline: object = None
        self._labels: dict[str, tuple[object, ...]] = {}  # of each body by its text
        self._bodies: dict[tuple[int, int], _Body] = {}  # by the numbers of the file and of the body in it

    def check(self, sources: Sources, expressions: Expressions, behaviors: ElaboratedBehaviors) -> None:
        """Report the messages of all bodies; those with cached messages are deferred."""
        if sources.diagnostics:  # after syntax errors, trees depend on more than their text
            for found in bodies(expressions.program):
                behaviors.add(found)
            return
        known = self._known(sources, expressions)
        keys = _keys(sources)
        kept: dict[tuple[int, int], _Body] = {}
        is_whole = True  # all messages were about their own body
        for found in bodies(expressions.program):
            key, text = keys[found.directive], found.directive.span.text
            body = known.get(key)
            if body is not None and body.text == text:
                for message in body.messages:
                    expressions.bag.put(_moved(message, found.directive.span.file, found.directive.span.start))
                behaviors.leave(found)
                kept[key] = body
                continue
            noted = expressions.applications.count
            with expressions.bag.copied() as messages:
                behaviors.add(found)
            is_whole &= all(_is_within(message.primary.span, found) for message in messages)
            is_own = all(_is_within(label.span, found) for message in messages for label in message.secondary)
            is_stable = all(
                message.code != behavior_messages.FILE_NOT_FOUND for message in messages
            )  # the file may appear
            if is_own and is_stable and noted == expressions.applications.count:
                start = -found.directive.span.start
                file = found.directive.span.file
                kept[key] = _Body(text, tuple(_moved(message, file, start) for message in messages))
        self._bodies = kept if is_whole and not expressions.bag.is_full else {}

    def _known(self, sources: Sources, expressions: Expressions) -> dict[tuple[int, int], _Body]:
        """Return the bodies with cached messages, if their surroundings are unchanged."""
        directives = [found for module in sources.modules for found in _directives(module)]
        self._labels = {
            found.span.text: self._labels.get(found.span.text) or tuple(_labels(found)) for found in directives
        }
        modules = [_outline(module, self._labels) for module in sources.modules]
        outline = (modules, sources.uses, expressions.strict)
        known = self._bodies if outline == self._outline else {}
        self._outline = outline
        return known


def bodies(program: Program) -> Iterator[DoFound]:
    """Yield the `do` of each scenario and action that declares one."""
    for symbol in program.behaviors.values():
        found = symbol.do
        if found is not None and found.owner is symbol:
            yield found


def _directives(module: Module) -> Iterator[ast.DoDirective]:
    """Yield all bodies in a file."""
    for statement in module.tree.statements:
        if isinstance(statement, ast.StructuredTypeDeclaration | ast.StructuredTypeExtension):
            yield from (member for member in statement.members if isinstance(member, ast.DoDirective))


def _keys(sources: Sources) -> dict[ast.DoDirective, tuple[int, int]]:
    """Return the numbers of the file and of the body in it, for each body."""
    return {
        found: (number, place)
        for number, module in enumerate(sources.modules)
        for place, found in enumerate(_directives(module))
    }


def _outline(module: Module, labels: Mapping[str, object]) -> object:
    """Return the text that bodies depend on: statements without bodies, and the labels of bodies."""
    text = module.file.text
    if module.library is not None:
        return module.file.name, text
    parts: list[object] = [module.file.name]
    directives = {found.span.start: found for found in _directives(module)}
    for statement in module.tree.statements:
        start = statement.span.start
        if isinstance(statement, ast.StructuredTypeDeclaration | ast.StructuredTypeExtension):
            for member in statement.members:
                found = directives.get(member.span.start)
                if found is not None:
                    parts += text[start : found.span.start], labels[found.span.text]
                    start = found.span.end
        parts.append(text[start : statement.span.end])
    return parts


def _labels(directive: ast.DoDirective) -> Iterator[tuple[int, str, str]]:
    """Yield the labels in a body: depth, name, and invoked behavior."""
    pending = [(0, directive.member)]
    while pending:
        depth, member = pending.pop()
        body = member.body
        if member.label is not None:
            invocation = body.invocation if isinstance(body, ast.BehaviorInvocation) else None
            target = invocation.function.span.text if invocation is not None else type(body).__name__
            yield depth, member.label.text, target
        if isinstance(body, ast.Composition):
            pending += [(depth + 1, inner) for inner in reversed(body.members)]


def _is_within(span: Span, found: DoFound) -> bool:
    body = found.directive.span
    return span.file is body.file and body.start <= span.start and span.end <= body.end


def _moved(message: Diagnostic, file: SourceFile, shift: int) -> Diagnostic:
    """Copy a message for a moved body; offsets grow by `shift`."""

    def label(old: Label) -> Label:
        return Label(Span(file, old.span.start + shift, old.span.end + shift), old.text)

    return replace(message, primary=label(message.primary), secondary=tuple(map(label, message.secondary)))
