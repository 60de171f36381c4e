"""The example of the README behaves as stated there."""

import re
import shlex
from pathlib import Path

import pytest

from seoro.cli.main import main

PROJECT = Path(__file__).parents[2]


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_the_example_takes_the_simulated_time_that_the_readme_states(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    readme = (PROJECT / "README.md").read_text()
    found = re.search(r"^\$ seoro (exec .*)\n\.\.\.\n(passed  \w+ in [\d.]+ s of its clock)", readme, re.MULTILINE)
    assert found is not None
    monkeypatch.chdir(PROJECT)
    arguments = [str(tmp_path) if each == "out/" else each for each in shlex.split(found[1])]
    assert main(arguments) == 0
    assert found[2] in capsys.readouterr().out
