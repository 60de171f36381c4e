"""The output folder of `seoro exec -o`: results of one run at a time, files of others untouched."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.embed.output_folder import OutputFolder
from seoro.runtime.execution.outputs import INDEX, Outputs

LOGIC = "import osc.helpers\nscenario main:\n    do log('x')\n"
COVERED = "scenario main:\n    n: int = 3\n    cover(n)\n    do wait elapsed(0s)\n"
INVALID = "scenario main:\n    do no_such_action()\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in {"logic": LOGIC, "covered": f"import osc.types\n{COVERED}", "invalid": INVALID}.items():
        (tmp_path / f"{name}.osc").write_text(text)
    return tmp_path


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {INDEX}


def test_a_run_removes_the_results_of_the_run_before(folder: Path) -> None:
    assert main(["exec", "covered.osc", "-o", "out"]) == 0
    assert "coverage.json" in names(folder / "out")
    assert main(["exec", "logic.osc", "-o", "out"]) == 0
    assert names(folder / "out") == {"trace.jsonl", "test.xml"}


def test_an_invalid_scenario_leaves_no_results_of_the_run_before(folder: Path) -> None:
    main(["exec", "covered.osc", "-o", "out"])
    assert main(["exec", "invalid.osc", "-o", "out"]) == 2
    assert names(folder / "out") == {"test.xml"}
    assert "no_such_action" in (folder / "out" / "test.xml").read_text()


def test_a_refused_run_leaves_no_empty_trace(folder: Path) -> None:
    arguments = ["exec", "logic.osc", "-o", "out", "--trace", "t.jsonl", "--set", "unknown=3"]
    assert main(arguments) == 2
    assert names(folder / "out") == {"test.xml"}
    assert not (folder / "t.jsonl").exists()


def test_a_dry_run_leaves_the_folder_as_it_is(folder: Path) -> None:
    main(["exec", "covered.osc", "-o", "out"])
    before = names(folder / "out")
    assert main(["exec", "logic.osc", "-o", "out", "-n"]) == 0
    assert names(folder / "out") == before


def test_files_of_others_stay(folder: Path) -> None:
    output = folder / "out"
    output.mkdir()
    (output / "notes.txt").write_text("mine")
    main(["exec", "covered.osc", "-o", "out"])
    (output / "log.txt").write_text("mine, too")
    main(["exec", "logic.osc", "-o", "out"])
    assert names(output) == {"trace.jsonl", "test.xml", "notes.txt", "log.txt"}


def test_files_that_appear_during_a_run_are_its_results(folder: Path) -> None:
    output = OutputFolder(folder / "out")
    output.claim()
    (folder / "out" / "bag").mkdir()
    (folder / "out" / "bag" / "data").write_text("")
    (folder / "out" / "from_a_program.txt").write_text("")
    output.close()
    OutputFolder(folder / "out").claim()
    assert names(folder / "out") == set()


def test_files_of_a_killed_run_are_its_results(folder: Path) -> None:
    OutputFolder(folder / "out").claim()
    Outputs().write(folder / "out", "picture.png", b"", "a picture")  # and it is never closed
    OutputFolder(folder / "out").claim()
    assert names(folder / "out") == set()


def test_an_index_that_names_places_elsewhere_removes_nothing_there(folder: Path) -> None:
    (folder / "keep.txt").write_text("")
    (folder / "out").mkdir()
    (folder / "out" / INDEX).write_text("../keep.txt\n/etc/hosts\n..\n.\n\n")
    OutputFolder(folder / "out").claim()
    assert (folder / "keep.txt").exists()


@pytest.mark.parametrize("option", ["--trace", "--junit"])
def test_an_output_that_is_an_input_is_refused(
    folder: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "link.osc").symlink_to("logic.osc")
    assert main(["exec", "logic.osc", option, "link.osc"]) == 2
    assert "the output would overwrite" in capsys.readouterr().err
    assert (folder / "logic.osc").read_text() == LOGIC


def test_an_imported_file_is_an_input(folder: Path) -> None:
    (folder / "main.osc").write_text('import "logic.osc"\nimport osc.types\nscenario other:\n    do main()\n')
    assert main(["exec", "main.osc", "--trace", "logic.osc"]) == 2
    assert (folder / "logic.osc").read_text() == LOGIC
