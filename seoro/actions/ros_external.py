"""The action of `osc.ros` that checks messages with a function of a Python file."""

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

from seoro.actions.ros_checks import CheckOptions, check
from seoro.actions.ros_support import TOPIC
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import ObservedSystem, RosMessage
from seoro.runtime.functions.actions import action

_EXECUTING: Final = Lock()  # held while a file is executed


@action(
    "check_data_external",
    anywhere=ObservedSystem,
    files=("file_path",),
    ros=TOPIC,
)
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
    """Wait for a message that a function of a Python file accepts."""
    function = await anyio.to_thread.run_sync(_function, ctx.resolve_path(file_path), function_name)

    def judge(message: RosMessage) -> str:
        answer = function(message.message)
        if not isinstance(answer, bool):
            raise ActionFailed(f"invalid result of `{function_name}`: expected True or False, found `{answer!r}`")
        return "" if answer else f"`{function_name}` of {file_path} does not accept a message of {topic_name}"

    terms = CheckOptions(fail_if_no_data, fail_if_bad_comparison, wait_for_first_message)
    await check(ctx, topic_name, topic_type, qos_profile.member, judge, terms)


def _function(path: Path, name: str) -> Callable[[Any], object]:
    """Return a function of a file; each file is executed once per process.

    Raises:
        ActionFailed: The file or the function is missing.
    """
    with _EXECUTING:  # no other thread sees a half-executed module
        module = _module(path)
    function = getattr(module, name, None)
    if not callable(function):
        raise ActionFailed(f"unknown function `{name}` in {path}")
    return function  # type: ignore[no-any-return] # any callable that takes a message


def _module(path: Path) -> ModuleType:
    resolved = path.resolve()
    name = f"seoro_file_{sha256(str(resolved).encode()).hexdigest()[:16]}"
    if name not in sys.modules:
        spec = spec_from_file_location(name, resolved)
        if spec is None or spec.loader is None or not resolved.is_file():
            raise ActionFailed(f"Python file not found: {path}")
        module = module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]
