"""The examples of the documentation do what it says."""

import re
from pathlib import Path

import pytest

from seoro.cli.main import main

DOCS = Path(__file__).parents[1] / "docs"
LIBRARIES = DOCS / "libraries.md"
FILE = re.compile(r"^`([\w./]+)`:\n\n```\w*\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The files of the example of a library, in the working directory."""
    monkeypatch.chdir(tmp_path)
    write_example(LIBRARIES)
    return tmp_path


def write_example(page: Path) -> None:
    """Write the files that a page shows into the working directory."""
    for name, text in FILE.findall(page.read_text()):
        path = Path(name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_the_library_in_a_folder_runs(example: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "main.osc", "--clock", "virtual", "--seed", "1"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"0\.000 s +5\.0m\n", out)
    assert re.search(r"2\.000 s +tom is cheerful and gives [\d.]+ l to the rose\n", out)


def test_the_modifier_fits_its_declaration(example: Path, capsys: pytest.CaptureFixture[str]) -> None:
    [python] = re.findall(r"^```python\n(from seoro import Child.*?)^```$", LIBRARIES.read_text(), re.M | re.S)
    (example / "seoro.libraries/patience.osc").write_text(
        "import osc.types\nmodifier patiently:\n    duration: time\n"
    )
    (example / "seoro.libraries/patience.py").write_text(python)
    Path("main.osc").write_text("import osc.patience\n")
    assert main(["check", "main.osc"]) == 0, capsys.readouterr().err


def test_the_actions_of_the_page_about_actions_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_example(DOCS / "actions.md")
    assert main(["exec", "main.osc", "--clock", "virtual"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"0\.000 s +red: 1\n", out)
    assert re.search(r"0\.000 s +green is at 3/3\n", out)
    assert re.search(r"1\.000 s +red is off\n", out)


def test_the_sweep_ends_as_its_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    page = DOCS / "sweep.md"
    write_example(page)
    [shown] = re.findall(r"^```console\n\$ (.*?)^```$", page.read_text(), re.M | re.S)
    command, *lines = shown.splitlines()
    assert main(command.split()[1:]) == 1
    out = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line != "..."] == [line for line in out if line and "  pause=" not in line]
