"""What a scenario that comes over the network must not do, unless the executor allows it by name.

Two things let a scenario do on the executor's machine whatever its user can: programs that it starts, and
Python that it brings or names. Both are found in the text before anything of it runs, and refused as an invalid
scenario is. So is what it wants to reach on other machines. Files that it names are refused when it comes to them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from seoro.actions.processes import RUNNING_PROGRAMS
from seoro.bindings.modules import is_module, root_of
from seoro.bridges.session import is_local
from seoro.embed.options import Options
from seoro.errors import ActionFailed, InvalidScenario, InvalidUse
from seoro.lab.reading import read_lab
from seoro.lang import ast
from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.frozen import Frozen
from seoro.lang.libraries import Origin, library_files, own_libraries
from seoro.lang.loader import Reader, Sources, Unreadable, read_file
from seoro.lang.plan import Plan
from seoro.lang.source import Span
from seoro.located import Locate
from seoro.runtime.invocations import invocations

PYTHON: Final = "python"
NETWORK: Final = "network"
FILES: Final = "files"
CODE: Final = "E0500"
_FILES: Final = "check_data_external"  # runs Python of a file that it names
PERMISSIONS: Final = {
    PYTHON: "Python that a scenario brings with it, or names with `external`",
    FILES: "files of the executor's machine that were not sent",
    NETWORK: "simulators, bridges and ROS 2 systems of other machines",
    **{name: f"the action `{name}`, which starts programs" for name in RUNNING_PROGRAMS},
}


def vet_sources(sources: Sources, allowed: Collection[str]) -> None:
    """Refuse a scenario that would have Python imported.

    Raises:
        InvalidScenario: It would, and that is not allowed.
    """
    found = [] if PYTHON in allowed else list(_python(sources))
    if found:
        raise InvalidScenario(found)


def _python(sources: Sources) -> Iterator[Diagnostic]:
    trusted = {library.name for library in sources.libraries if library.origin is not Origin.BESIDE}
    for library in sources.libraries:
        root = root_of(library) if library.origin is Origin.BESIDE else None
        if root is not None and is_module(root, [library.module]):
            yield _refused(library.span, f"`{library.name}` brings Python with it", PYTHON)
    for module in sources.modules:
        if module.library not in trusted:
            for method in _externals(module.tree):
                yield _refused(method.span, "an external method calls Python", PYTHON)


def _externals(node: Any) -> Iterator[ast.ExternalMethod]:
    """The external methods in a tree of declarations; expressions and behaviors have none."""
    if isinstance(node, ast.ExternalMethod):
        yield node
    elif isinstance(node, tuple):
        for part in node:
            yield from _externals(part)
    elif isinstance(node, Frozen) and not isinstance(node, Span | ast.DoDirective):
        for name in node.__match_args__:
            yield from _externals(getattr(node, name))


def vet_plan(plan: Plan, allowed: Collection[str]) -> None:
    """Refuse a plan that starts programs, or runs the Python of a file.

    Raises:
        InvalidScenario: It does, and that is not allowed.
    """
    found = []
    for invocation in invocations(plan):
        name = invocation.action.rpartition(".")[2]
        needed = PYTHON if name == _FILES else name
        if needed in PERMISSIONS and needed not in allowed:
            found.append(_refused(invocation.span, f"this executor does not allow `{name}`", needed))
    if found:
        raise InvalidScenario(found)


def vet_endpoints(options: Options, allowed: Collection[str], reach: Collection[str]) -> None:
    """Refuse to reach what is on another machine.

    Args:
        options: How a scenario is to be run.
        allowed: Names of permissions.
        reach: Endpoints that may be reached all the same.

    Raises:
        InvalidUse: It would be reached, and that is not allowed.
    """
    for endpoint in _endpoints(options):
        vet_endpoint(endpoint, allowed, reach)


def vet_endpoint(endpoint: str, allowed: Collection[str], reach: Collection[str]) -> None:
    """Refuse to reach an endpoint on another machine; see `vet_endpoints`."""
    if NETWORK not in allowed and endpoint not in reach and not is_local(endpoint):
        raise InvalidUse(
            f"this executor does not let scenarios reach {endpoint}",
            help=f"whoever runs it can allow it: `seoro serve --allow {NETWORK}`, or `reach` in its policy",
        )


def _endpoints(options: Options) -> Iterator[str]:
    """All that a run would connect to."""
    if options.simulator is not None and options.simulator.endpoint is not None:
        yield options.simulator.endpoint
    if options.ros is not None:
        yield options.ros.endpoint
    if options.lab is not None:
        yield from read_lab(options.lab.file).endpoints


def keeping_to(folders: Iterable[Path], locate: Locate, allowed: Collection[str]) -> Locate:
    """Finds files that a scenario names while it runs, in some folders only unless others are allowed.

    Args:
        folders: With what was sent, and what the run leaves.
        locate: Finds what was sent.
        allowed: Names of permissions.

    What is returned raises `ActionFailed` for a file that may not be read.
    """
    if FILES in allowed:
        return locate
    homes = [folder.resolve() for folder in folders]

    def kept(path: Path) -> Path:
        found = locate(path)
        if not any(found.resolve().is_relative_to(home) for home in homes):
            raise ActionFailed(
                f"this executor does not let scenarios read {path}, which was not sent: whoever runs it can allow "
                f"it, by `seoro serve --allow {FILES}`"
            )
        return found

    return kept


def _refused(span: Span, what: str, permission: str) -> Diagnostic:
    return error(
        CODE,
        span,
        what,
        label="not allowed here",
        help=f"whoever runs the executor can allow it: `seoro serve --allow {permission}`",
    )


def check_permissions(names: Collection[str]) -> None:
    """Check that what is to be allowed is something that is not allowed by itself.

    Raises:
        InvalidUse: It is not.
    """
    for name in names:
        if name not in PERMISSIONS:
            raise InvalidUse(
                f"there is nothing to allow called '{name}'", help=f"there are {', '.join(PERMISSIONS)}"
            )


def reader_of(root: Path) -> Reader:
    """Reads the files of a bundle, and those of installed libraries; no others of this machine.

    Args:
        root: Folder of the bundle.
    """
    home = root.resolve()
    own = _resolved(own_libraries())

    @cache
    def installed() -> frozenset[Path]:  # which takes time to find out, and most scenarios do not need
        return _resolved(library_files(None))

    def read(path: Path) -> str | Unreadable:
        resolved = path.resolve()
        if resolved.is_relative_to(home) or resolved in own or resolved in installed():
            return read_file(path)
        return Unreadable("it is not part of what was sent")

    return read


def _resolved(libraries: Mapping[str, Path]) -> frozenset[Path]:
    return frozenset(file.resolve() for file in libraries.values())
