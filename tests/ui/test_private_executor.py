"""The executor of a site: rights of its runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.client import Client
from seoro.errors import SeoroError
from seoro.runtime.verdict import RunStatus, Verdict
from seoro.ui.private_executor import NAME, private_executor

pytestmark = pytest.mark.anyio

PROGRAM = "import osc.helpers\nscenario main:\n    do run_process('true')\n"


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    (tmp_path / "main.osc").write_text(PROGRAM)
    return tmp_path / "main.osc"


async def result(scenario: Path, state: Path, *, is_trusted: bool) -> Verdict:
    """Run a scenario on an executor of a site."""
    async with private_executor(state, is_trusted=is_trusted) as started, Client(started.endpoint) as client:
        run = await client.submit(NAME, scenario)
        return await run.result()


async def test_the_user_of_the_machine_may_do_what_exec_may_do(scenario: Path, tmp_path: Path) -> None:
    assert (await result(scenario, tmp_path / "state", is_trusted=True)).status is RunStatus.PASSED


async def test_others_have_the_permissions_of_an_executor(scenario: Path, tmp_path: Path) -> None:
    with pytest.raises(SeoroError, match="run_process"):
        await result(scenario, tmp_path / "state", is_trusted=False)
