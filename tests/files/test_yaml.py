"""Reading YAML: values of scenarios and command lines, and files that people write."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.embed.parameter_files import read_parameters
from seoro.errors import UsageError
from seoro.files.plain_yaml import MAX_DEPTH, read_yaml
from seoro.files.yaml_lines import FileError
from seoro.files.yaml_lines import read_yaml as read_file

DEEP = "[" * 100_000
SHARED = "first: &shared [1, 2]\nsecond: *shared"


def test_deep_nesting_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^nested too deeply$"):
        read_yaml(DEEP)
    with pytest.raises(FileError, match=r"^hall.yaml: invalid YAML: nested too deeply$"):
        read_file(DEEP, "hall.yaml")
    (tmp_path / "values.yaml").write_text(DEEP)
    with pytest.raises(UsageError, match=r"invalid YAML in .*values.yaml: nested too deeply$"):
        read_parameters(tmp_path / "values.yaml", "main")


def test_the_maximum_nesting_is_read() -> None:
    text = "[" * MAX_DEPTH + "]" * MAX_DEPTH
    assert str(read_yaml(text)) == str(read_file(text, "hall.yaml")) == text


def test_references_are_for_files_only() -> None:
    assert read_file(SHARED, "hall.yaml") == {"first": [1, 2], "second": [1, 2]}
    with pytest.raises(ValueError, match="unsupported alias"):
        read_yaml(SHARED)


def test_numbers_with_exponents_are_numbers() -> None:
    text = "[1e-05, -2.5E3, .5e1, 1.e+2, 0x1e5, 1e, e5, '1e5']"
    values = [1e-05, -2500.0, 5.0, 100.0, 0x1E5, "1e", "e5", "1e5"]
    assert read_yaml(text) == read_file(text, "hall.yaml") == values


@pytest.mark.parametrize("text", ["a: 1\nb: 2\na: 3", "a: 1\nb: 2\n'a': 3", "a: {\n  c: 2,\n  c: 3}"])
def test_keys_that_are_given_twice_are_refused_by_their_line(text: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"^hall.yaml:3: invalid YAML: duplicate key '[ac]', .* line [12]$"):
        read_file(text, "hall.yaml")
    with pytest.raises(ValueError, match="duplicate key"):
        read_yaml(text)
    (tmp_path / "values.yaml").write_text(text)
    with pytest.raises(UsageError, match="duplicate key"):
        read_parameters(tmp_path / "values.yaml", "main")


def test_merged_keys_may_be_given_again() -> None:
    text = "a: &a {x: 1, y: 2}\nb: &b {z: 3}\nc:\n  <<: *a\n  <<: *b\n  x: 4\n1: 5\n'1': 6"
    merged = {"a": {"x": 1, "y": 2}, "b": {"z": 3}, "c": {"x": 4, "y": 2, "z": 3}, 1: 5, "1": 6}
    assert read_file(text, "hall.yaml") == merged


def test_invalid_yaml_is_rejected_with_its_line() -> None:
    with pytest.raises(FileError, match=r"^hall.yaml:2: invalid YAML: "):
        read_file("robots:\n  - [", "hall.yaml")
    with pytest.raises(ValueError, match="line 2"):
        read_yaml("robots:\n  - [")
