"""Reading YAML: values of scenarios and command lines, and files that people write."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.errors import InvalidUse
from seoro.parameters import read_parameters
from seoro.plain_yaml import MAX_DEPTH, read_yaml
from seoro.yaml_files import FileError
from seoro.yaml_files import read_yaml as read_file

DEEP = "[" * 100_000
SHARED = "first: &shared [1, 2]\nsecond: *shared"


def test_what_is_nested_too_deeply_is_refused_wherever_it_stands(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"^it is nested too deeply$"):
        read_yaml(DEEP)
    with pytest.raises(FileError, match=r"^hall.yaml is no valid YAML: it is nested too deeply$"):
        read_file(DEEP, "hall.yaml")
    (tmp_path / "values.yaml").write_text(DEEP)
    with pytest.raises(InvalidUse, match=r"values.yaml is no YAML: it is nested too deeply$"):
        read_parameters(tmp_path / "values.yaml", "main")


def test_what_is_nested_as_deeply_as_may_be_is_read() -> None:
    text = "[" * MAX_DEPTH + "]" * MAX_DEPTH
    assert str(read_yaml(text)) == str(read_file(text, "hall.yaml")) == text


def test_references_are_for_files_only() -> None:
    assert read_file(SHARED, "hall.yaml") == {"first": [1, 2], "second": [1, 2]}
    with pytest.raises(ValueError, match="it has references"):
        read_yaml(SHARED)


def test_numbers_with_exponents_are_numbers() -> None:
    text = "[1e-05, -2.5E3, .5e1, 1.e+2, 0x1e5, 1e, e5, '1e5']"
    values = [1e-05, -2500.0, 5.0, 100.0, 0x1E5, "1e", "e5", "1e5"]
    assert read_yaml(text) == read_file(text, "hall.yaml") == values


@pytest.mark.parametrize("text", ["a: 1\nb: 2\na: 3", "a: 1\nb: 2\n'a': 3", "a: {\n  c: 2,\n  c: 3}"])
def test_keys_that_are_given_twice_are_refused_by_their_line(text: str, tmp_path: Path) -> None:
    with pytest.raises(
        FileError, match=r"^hall.yaml:3: no valid YAML: the key '[ac]' is given twice, .* line [12]$"
    ):
        read_file(text, "hall.yaml")
    with pytest.raises(ValueError, match="is given twice"):
        read_yaml(text)
    (tmp_path / "values.yaml").write_text(text)
    with pytest.raises(InvalidUse, match="is given twice"):
        read_parameters(tmp_path / "values.yaml", "main")


def test_merged_keys_may_be_given_again() -> None:
    text = "a: &a {x: 1, y: 2}\nb: &b {z: 3}\nc:\n  <<: *a\n  <<: *b\n  x: 4\n1: 5\n'1': 6"
    merged = {"a": {"x": 1, "y": 2}, "b": {"z": 3}, "c": {"x": 4, "y": 2, "z": 3}, 1: 5, "1": 6}
    assert read_file(text, "hall.yaml") == merged


def test_what_is_no_yaml_is_refused_by_its_line() -> None:
    with pytest.raises(FileError, match=r"^hall.yaml:2: no valid YAML: "):
        read_file("robots:\n  - [", "hall.yaml")
    with pytest.raises(ValueError, match="line 2"):
        read_yaml("robots:\n  - [")
