"""The examples of the documentation do what it says."""

import re
from pathlib import Path

import pytest

from seoro.cli.main import main

LIBRARIES = Path(__file__).parents[1] / "docs" / "libraries.md"
FILE = re.compile(r"^`([\w./]+)`:\n\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files of the example, in the working directory."""
    for name, text in FILE.findall(LIBRARIES.read_text()):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_library_in_a_folder_runs(example: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "main.osc", "--clock", "virtual", "--seed", "1"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"0\.000 s +5\.0\n", out)
    assert re.search(r"2\.000 s +tom is cheerful and gives [\d.]+ l to the rose\n", out)


def test_the_modifier_fits_its_declaration(example: Path, capsys: pytest.CaptureFixture[str]) -> None:
    [python] = re.findall(r"^```python\n(from seoro import Child.*?)^```$", LIBRARIES.read_text(), re.M | re.S)
    (example / "seoro.libraries/patience.osc").write_text(
        "import osc.types\nmodifier patiently:\n    duration: time\n"
    )
    (example / "seoro.libraries/patience.py").write_text(python)
    Path("main.osc").write_text("import osc.patience\n")
    assert main(["check", "main.osc"]) == 0, capsys.readouterr().err
