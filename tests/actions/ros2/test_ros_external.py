"""The action of `osc.ros` that lets a function of a Python file look at messages."""

import re
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Timer
from types import SimpleNamespace

import pytest

from seoro.actions.ros_external import _function
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos

PYTHON = """
def is_even(message):
    return message.data % 2 == 0

def is_never(message):
    return False

def is_odd(message):
    return message.data % 2
"""


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("'look.py', 'is_even'", "^$"),
        ("'look.py', 'is_never', fail_if_bad_comparison: true", "`is_never` of look.py does not accept a message"),
        ("'look.py', 'is_odd'", "invalid result of `is_odd`: expected True or False, found `[01]`"),
        ("'look.py', 'is_none'", "unknown function `is_none` in .*look.py"),
        ("'nowhere.py', 'is_even'", "Python file not found: .*nowhere.py"),
    ],
)
async def test_a_function_checks_messages(arguments: str, reason: str, run_ros: RunRos, tmp_path: Path) -> None:
    (tmp_path / "look.py").write_text(PYTHON)
    file, function = arguments.split(", ", 1)
    ran = await run_ros(
        "scenario main:\n    do check_data_external('/count', 'std_msgs/msg/Int64', "
        f"file_path: {file}, function_name: {function}) with:\n        timeout(20s)\n"
    )
    assert ran.verdict.status is (RunStatus.PASSED if reason == "^$" else RunStatus.FAILED), ran.verdict.reason
    assert re.search(reason, ran.verdict.reason)


def test_a_second_import_of_a_file_waits_for_the_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = SimpleNamespace(reached=Event(), opened=Event())
    monkeypatch.setitem(sys.modules, "gate", gate)
    file = tmp_path / "slow.py"
    file.write_text("import gate\ngate.reached.set()\ngate.opened.wait(20)\n\ndef right(message): return True\n")
    with ThreadPoolExecutor(2) as others:
        first = others.submit(_function, file, "right")
        assert gate.reached.wait(20)
        second = others.submit(_function, file, "right")
        Timer(0.05, gate.opened.set).start()
        assert second.result() is first.result()
