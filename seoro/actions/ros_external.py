"""The action of `osc.ros` that lets a function of a Python file look at messages."""

from __future__ import annotations

import sys
from collections.abc import Callable
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any, Final

import anyio.to_thread

from seoro.actions.ros_checks import Terms, check
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext
from seoro.runtime.ros_system import Ros2System, RosMessage

_EXECUTING: Final = Lock()  # a file


@action("check_data_external", anywhere=Ros2System, files=("file_path",))
async def check_data_external(
    ctx: ActionContext,
    topic_name: str,
    topic_type: str,
    qos_profile: EnumValue,
    file_path: str,
    function_name: str,
    fail_if_no_data: bool,
    fail_if_bad_comparison: bool,
    wait_for_first_message: bool,
) -> None:
    """Wait for a message of which a function of a Python file says that it is right."""
    function = await anyio.to_thread.run_sync(_function, ctx.place_of(file_path), function_name)

    def judge(message: RosMessage) -> str:
        answer = function(message.message)
        if not isinstance(answer, bool):
            raise ActionFailed(f"`{function_name}` says `{answer!r}` of a message, and not True or False")
        return "" if answer else f"`{function_name}` of {file_path} does not accept a message of {topic_name}"

    terms = Terms(fail_if_no_data, fail_if_bad_comparison, wait_for_first_message)
    await check(ctx, topic_name, topic_type, qos_profile.member, judge, terms)


def _function(path: Path, name: str) -> Callable[[Any], object]:
    """A function of a file, which a process executes once.

    Raises:
        ActionFailed: There is none.
    """
    with _EXECUTING:  # who comes second must not find half of it
        module = _module(path)
    function = getattr(module, name, None)
    if not callable(function):
        raise ActionFailed(f"there is no function `{name}` in {path}")
    return function  # type: ignore[no-any-return] # whatever it is, it is called with a message


def _module(path: Path) -> ModuleType:
    resolved = path.resolve()
    name = f"seoro_file_{sha256(str(resolved).encode()).hexdigest()[:16]}"
    if name not in sys.modules:
        spec = spec_from_file_location(name, resolved)
        if spec is None or spec.loader is None or not resolved.is_file():
            raise ActionFailed(f"there is no Python file {path}")
        module = module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
