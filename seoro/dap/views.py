"""`Views`: a paused run as threads, frames and variables of the protocol.

A thread is a branch of the tree of behaviors, and a frame is a behavior in it. Numbers of frames and of variables
are valid until the run continues.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from seoro.dap.run_control import RunControl
from seoro.errors import UsageError
from seoro.runtime.debug.debugger import Pause
from seoro.runtime.debug.inspection import (
    Branch,
    Frame,
    Member,
    arguments_of,
    branches,
    frame_of,
    globals_of,
    has_parts,
    parts_of,
    variables_of,
)
from seoro.runtime.execution.context import BehaviorScope
from seoro.runtime.kernel.task import Task
from seoro.runtime.values.values import Value as RunValue

_WAITING = "the run"  # name of the only thread before the first behavior starts


class Views:
    """Views of one run.

    Args:
        control: The run.
        first_line: Number of the first line, and of the first column, for the editor.
    """

    def __init__(self, control: RunControl, first_line: int) -> None:
        self._control = control
        self._shift = first_line - 1
        self._numbers: dict[Task, int] = {}
        self._frames: list[Frame] = []
        self._members: list[Callable[[], Sequence[Member]]] = []

    def forget(self) -> None:
        """Forget frames and variables: the run continues."""
        self._frames.clear()
        self._members.clear()

    # -------------------------------------------------------- threads and frames

    def _branches(self) -> tuple[Branch, ...]:
        debugger = self._control.debugger
        return branches(debugger.services, self._numbers) if debugger.has_begun else ()

    def threads(self) -> Mapping[str, Any]:
        """Return the threads."""
        found = [{"id": each.number, "name": each.path} for each in self._branches()]
        return {"threads": found or [{"id": 1, "name": _WAITING}]}

    def thread_of(self, pause: Pause) -> int:
        """Return the thread of a pause; the first one if time was passing."""
        task = pause.scope.task if pause.scope is not None else None
        found = self._branches()
        own = next((each.number for each in found if task is not None and each.frames[0].scope.task is task), None)
        return own if own is not None else next((each.number for each in found), 1)

    def stack(self, thread: int) -> Mapping[str, Any]:
        """Return the frames of a thread, the innermost first."""
        self._check_paused()
        branch = next((each for each in self._branches() if each.number == thread), None)
        frames = list(branch.frames) if branch is not None else []
        pause = self._control.debugger.pause_state
        if pause is not None and pause.has_ended and pause.scope is not None and thread == self.thread_of(pause):
            frames.insert(0, frame_of(pause.scope))
        return {"stackFrames": [self._frame(each) for each in frames], "totalFrames": len(frames)}

    def _frame(self, frame: Frame) -> Mapping[str, Any]:
        self._frames.append(frame)
        line, column = frame.span.file.position(frame.span.start)
        end_line, end_column = frame.span.file.position(frame.span.end)
        name = frame.name if frame.name == frame.kind else f"{frame.kind} {frame.name}"
        path = self._control.debugger.breakpoints.path_of(frame.span)
        return {
            "id": len(self._frames),
            "name": f"{name}, since {frame.since:.3f} s",
            "source": {"name": frame.span.file.name, **({"path": str(path)} if path is not None else {})},
            "line": line + self._shift,
            "column": column + self._shift,
            "endLine": end_line + self._shift,
            "endColumn": end_column + self._shift,
        }

    def scope_of(self, frame: object) -> BehaviorScope:
        """Return the scope of a frame by its number; that of the first branch without a number.

        Raises:
            UsageError: The run is not paused, or has no such frame.
        """
        self._check_paused()
        if frame is None:
            found = self._branches()
            if not found:
                raise UsageError("no behavior is running")
            return found[0].frames[0].scope
        if not isinstance(frame, int) or not 0 < frame <= len(self._frames):
            raise UsageError(f"unknown frame {frame}; it belongs to an earlier pause")
        return self._frames[frame - 1].scope

    def _check_paused(self) -> None:
        if self._control.debugger.pause_state is None:
            raise UsageError("the run is not paused")

    # -------------------------------------------------------- variables

    def scopes(self, frame: int) -> Mapping[str, Any]:
        """Return the groups of variables of a frame."""
        scope = self.scope_of(frame)
        services = scope.context.services
        groups: list[tuple[str, Callable[[], Sequence[Member]]]] = [
            (f"Scenario {scope.context.instance.declaration.name}", partial(variables_of, scope)),
            ("Arguments", partial(arguments_of, scope)),
            ("Global parameters", partial(globals_of, services)),
            ("Activity", self._activities),
        ]
        found = [
            {"name": name, "variablesReference": self._refer(members), "expensive": False}
            for name, members in groups
            if members()
        ]
        return {"scopes": found}

    def _activities(self) -> Sequence[Member]:
        """Return what each branch does."""
        return [Member(each.path, each.activity, "", each.activity) for each in self._branches() if each.activity]

    def variables(self, reference: int) -> Mapping[str, Any]:
        """Return the variables of a group, or the parts of a value.

        Raises:
            UsageError: The reference is unknown.
        """
        if not 0 < reference <= len(self._members):
            raise UsageError(f"unknown variables {reference}; they belong to an earlier pause")
        return {"variables": [self._variable(each) for each in self._members[reference - 1]()]}

    def _variable(self, member: Member) -> Mapping[str, Any]:
        return {
            "name": member.name,
            "value": member.text,
            "type": member.type_name,
            "variablesReference": self.reference_of(member.value),
        }

    def reference_of(self, value: RunValue) -> int:
        """Return the reference of the parts of a value; 0 without parts."""
        if not has_parts(value):
            return 0
        return self._refer(partial(parts_of, value, self._control.debugger.services))

    def _refer(self, members: Callable[[], Sequence[Member]]) -> int:
        self._members.append(members)
        return len(self._members)
