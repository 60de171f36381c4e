"""The methods of the struct `common` in `osc.helpers`."""

from pathlib import Path

import pytest

from seoro import UsageError
from seoro.embed.options import Options
from tests.runtime.conftest import Prepare, RunText

SCENARIO = """
scenario main:
    c: common
    folder: string = c.get_{}_directory()
    do log(folder)
"""


async def test_the_folder_of_the_scenario_file_is_returned(run_text: RunText, tmp_path: Path) -> None:
    ran = await run_text(SCENARIO.format("scenario_file"))
    assert ran.logs == [(0.0, str(tmp_path))]


async def test_the_folder_for_results_is_returned(prepare_text: Prepare, tmp_path: Path) -> None:
    options = Options(clock="virtual", output_directory=tmp_path / "out")
    async with prepare_text(SCENARIO.format("output"), options) as run:
        assert run.parameters["folder"] == str(tmp_path / "out")


async def test_a_run_without_a_folder_for_results_reports_it(prepare_text: Prepare) -> None:
    with pytest.raises(UsageError, match="`get_output_directory` failed: the run has no"):
        async with prepare_text(SCENARIO.format("output")):
            pass
