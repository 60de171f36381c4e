"""Tasks are created in the kernel only, each in an `asyncio.TaskGroup`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import seoro.runtime
from tests.leftovers import Leftovers
from tests.runtime.conftest import RunText

RUNTIME = Path(seoro.runtime.__file__).parent
LONGEST = 350  # lines
CREATES = ("create_task", "ensure_future")


def uses(path: Path) -> Iterator[str]:
    """Yield the expressions of a file that name functions which create tasks."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Attribute | ast.Name):
            name = node.attr if isinstance(node, ast.Attribute) else node.id
            if name in CREATES:
                yield ast.unparse(node)
        elif isinstance(node, ast.ImportFrom):
            yield from (alias.name for alias in node.names if alias.name in CREATES)


def test_tasks_are_created_in_the_groups_of_the_kernel_only() -> None:
    found = {
        path.relative_to(RUNTIME).as_posix(): set(texts)
        for path in sorted(RUNTIME.rglob("*.py"))
        if (texts := list(uses(path)))
    }
    assert found == {
        "kernel/scheduler.py": {"self._asyncio_group.create_task", "group.create_task"},
        "kernel/task_group.py": {"self._asyncio_group.create_task"},
    }


def test_the_kernel_imports_no_other_part_of_seoro() -> None:
    for path in (RUNTIME / "kernel").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("seoro"):
                assert (node.module or "").startswith("seoro.runtime.kernel."), path.name


def test_no_file_of_the_runtime_is_longer_than_350_lines() -> None:
    lengths = {path.name: len(path.read_text().splitlines()) for path in RUNTIME.rglob("*.py")}
    assert not {name: length for name, length in lengths.items() if length > LONGEST}


TEXT = """
scenario main:
    event never
    do parallel(overlap: any):
        serial:
            wait elapsed(1s)
        wait @never
    with:
        timeout(2s)
"""


async def test_runs_of_tests_are_checked_for_leftovers(
    run_text: RunText, leftovers: Leftovers, monkeypatch: pytest.MonkeyPatch
) -> None:
    await run_text(TEXT)
    assert leftovers.runs == 1
    assert leftovers.tasks > 3
    with monkeypatch.context() as patch:
        patch.setattr("seoro.runtime.kernel.channel.Subscription.close", lambda self: None)
        with pytest.raises(BaseExceptionGroup) as raised:
            await run_text(TEXT)
    assert "something is left" in str(raised.value.exceptions)
