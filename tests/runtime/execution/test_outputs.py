"""Output files of actions, and their valid names."""

from pathlib import Path

import pytest

from seoro.errors import ActionFailed
from seoro.runtime.execution.outputs import Outputs


@pytest.mark.parametrize("name", ["measurements.json", "trace.jsonl", "../up.txt", ".hidden", ""])
def test_invalid_output_file_names_are_refused(name: str, tmp_path: Path) -> None:
    outputs = Outputs()
    with pytest.raises(ActionFailed, match="invalid output file name"):
        outputs.write(tmp_path, name, b"", "a test")
    assert outputs.files == []


def test_a_second_file_of_a_name_gets_a_number(tmp_path: Path) -> None:
    outputs = Outputs()
    left = [outputs.write(tmp_path / "out", "a.txt", text, "a test") for text in (b"one", b"two")]
    assert [(path.name, path.read_bytes()) for path in left] == [("a.txt", b"one"), ("a_2.txt", b"two")]
