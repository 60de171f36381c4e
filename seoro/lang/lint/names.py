"""Names of the entry file that nothing uses.

A name is used if its text occurs elsewhere in a file of the user, with any meaning: a missed warning is better
than a wrong one.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Set
from pathlib import Path
from typing import Final

from seoro.lang import ast
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import suspicious as messages
from seoro.lang.loader import Module, path_of
from seoro.lang.source import Span
from seoro.lang.symbols import Structured, TypeSymbol
from seoro.lang.tree import walk

_ANY_WORD: Final = re.compile(r"\w+")
_IMPORT: Final = re.compile(r"import\s+(?:'[^'\r\n]*'|\"[^\"\r\n]*\"|[\w.]+)")


def unused_members(checked: Checked, scenario: TypeSymbol, words: Counter[str]) -> Iterator[Diagnostic]:
    """Yield warnings about parameters, variables and events of a scenario with a body.

    Scenarios without a body are bases of others, which may be in files that import this one. Actors take part in a
    run, and structs are sampled by their coverage, without being named.

    Args:
        checked: The checked file.
        scenario: A scenario of the entry file.
        words: Numbers of the identifiers in files of the user.
    """
    if scenario.do is None or scenario.do.owner is not scenario:
        return
    file = checked.sources.entry.file
    for field in scenario.fields.values():
        if field.span.file is file and words[field.text] == 1 and not isinstance(field.type, Structured):
            kind = "variable" if field.is_variable else "parameter"
            yield messages.unused_parameter(field.span, field.text, kind)
    for event in scenario.events.values():
        if event.span.file is file and words[event.text] == 1:
            yield messages.unused_event(event.span, event.text)


def unused_labels(checked: Checked, members: Iterable[ast.TypeMember]) -> Iterator[Diagnostic]:
    """Yield warnings about labels that occur nowhere else in files of the user, not even in strings and comments.

    Args:
        checked: The checked file.
        members: Members of a scenario that the entry file declares.
    """
    labels = [
        found.label
        for member in members
        if isinstance(member, ast.DoDirective)
        for found in walk(member)
        if isinstance(found, ast.DoMember) and found.label is not None
    ]
    if not labels:
        return
    texts = (module.file.text for module in checked.sources.modules if module.library is None)
    counts = Counter(word for text in texts for word in _ANY_WORD.findall(text))
    for label in labels:
        if counts[label.text] == 1:
            yield messages.unused_label(label.span, label.text)


def shadowing_names(checked: Checked) -> Iterator[Diagnostic]:
    """Yield warnings about names of the entry file that hide another declaration of a user.

    Fields hide global parameters, and parameters of methods hide fields.
    """
    file = checked.sources.entry.file
    users = {module.file for module in checked.sources.modules if module.library is None}
    shared = {found.text: found for found in checked.program.globals.values() if found.span.file in users}
    for symbol in checked.program.structured():
        for field in symbol.fields.values():
            if field.text in shared and field.span.file is file:
                yield messages.shadowed(field.span, field.text, shared[field.text].span)
        own = [method for method in symbol.methods.values() if method.span.file is file]
        fields = {field.text: field for field in symbol.inventory.fields.values()} if own else {}
        for method in own:
            for parameter in method.parameters.values():
                if parameter.text in fields and fields[parameter.text].span.file in users:
                    yield messages.shadowed(parameter.span, parameter.text, fields[parameter.text].span)


def unused_imports(checked: Checked, words: Set[str]) -> Iterator[Diagnostic]:
    """Yield warnings about imports of which the entry file uses no name.

    An import is used if its file declares a word of the entry file. The imports of that file count, too, for words
    that no other import of the entry file declares.

    Args:
        checked: The checked file.
        words: Identifiers of the entry file.
    """
    entry = checked.sources.entry
    modules = {_key(module): module for module in checked.sources.modules}
    imports = [
        (statement, module)
        for statement in entry.tree.statements
        if isinstance(statement, ast.ImportModule | ast.ImportUri)
        and (module := _imported(statement, entry, modules)) is not None
    ]
    own = {id(module): _declared(module) & words if not _extends(module) else words for _, module in imports}
    for statement, module in imports:
        if own[id(module)]:
            continue
        others: set[str] = set()
        for _, other in imports:
            if other is not module:
                others |= own[id(other)]
        below = _reached(module, modules)
        if not any(_extends(found) or (_declared(found) & words) - others for found in below):
            name = ".".join(statement.path) if isinstance(statement, ast.ImportModule) else statement.uri
            yield messages.unused_import(_without_comment(statement), name)


def _without_comment(statement: ast.ImportModule | ast.ImportUri) -> Span:
    """Return the span of an import without blanks and comments behind it."""
    found = _IMPORT.match(statement.span.text)
    length = found.end() if found is not None else 0
    return Span(statement.span.file, statement.span.start, statement.span.start + length)


def _key(module: Module) -> str | Path | None:
    if module.library is not None:
        return module.library
    return module.file.path.resolve() if module.file.path is not None else None


def _imported(
    statement: ast.Statement, importer: Module, modules: Mapping[str | Path | None, Module]
) -> Module | None:
    """Return the loaded file of an import; None for other statements and unknown files."""
    match statement:
        case ast.ImportModule(path):
            return modules.get(".".join(path))
        case ast.ImportUri(uri):
            relative = path_of(uri)
            if relative is None or importer.file.path is None:
                return None
            return modules.get((importer.file.path.parent / relative).resolve())
        case _:
            return None


def _reached(start: Module, modules: Mapping[str | Path | None, Module]) -> list[Module]:
    """Return the direct and indirect imports of a file."""
    found: list[Module] = []
    pending = [start]
    while pending:
        module = pending.pop()
        for statement in module.tree.statements:
            target = _imported(statement, module, modules)
            if target is not None and target is not start and target not in found:
                found.append(target)
                pending.append(target)
    return found


def _extends(module: Module) -> bool:
    """Return whether a file extends types, and so matters without being named."""
    kinds = ast.StructuredTypeExtension | ast.PrimitiveTypeExtension | ast.EnumTypeExtension | ast.ExportStatement
    return module.library is None and any(isinstance(found, kinds) for found in module.tree.statements)


def _declared(module: Module) -> set[str]:
    """Return the names that a file declares outside of types, and the members of its enumerations."""
    found: set[str] = set()
    for statement in module.tree.statements:
        match statement:
            case ast.GlobalParameterDeclaration(parameter):
                found.update(name.text for name in parameter.names)
            case ast.EnumDeclaration(name, members) | ast.EnumTypeExtension(name, members):
                found.add(name.text)
                found.update(member.name.text for member in members)
            case ast.NamespaceStatement(name):
                found.add(name)
            case ast.PhysicalTypeDeclaration(name) | ast.UnitDeclaration(name):
                found.add(name.text)
            case ast.StructDeclaration(name) | ast.ActorDeclaration(name):
                found.add(name.text)
            case ast.ScenarioDeclaration(name) | ast.ActionDeclaration(name) | ast.ModifierDeclaration(name):
                found.add(name.name.text)
            case ast.StructuredTypeExtension(name, members):
                found.add(name.name.text)
                for member in members:
                    found.update(_member_names(member))
            case ast.PrimitiveTypeExtension(_, members):
                for member in members:
                    found.update(_member_names(member))
            case _:
                pass
    return found


def _member_names(member: ast.TypeMember) -> Iterator[str]:
    match member:
        case ast.ParameterDeclaration(names) | ast.VariableDeclaration(names):
            yield from (name.text for name in names)
        case ast.EventDeclaration(name) | ast.MethodDeclaration(name):
            yield name.text
        case _:
            pass
