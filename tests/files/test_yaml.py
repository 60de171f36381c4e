"""Reading YAML: values of scenarios and command lines, and files that people write."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from seoro.embed.parameter_files import read_parameters
from seoro.errors import UsageError
from seoro.files.plain_yaml import MAX_DEPTH, _load, _Loader, _PythonLoader, load_yaml, read_yaml
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


TEXTS = (
    "a: 1e-05\nb: 0x10\nc: 1_000\nd: 2001-01-01\ne: yes\n",
    "a: &x [1]\nb: *x",
    "x: {<<: {a: 1}, a: 2}",
    "? a\n: b",
    "k: >-\n  é\n  \U0001f600",
    "",
    "[a, b",
    "a: 1\na: 2",
    "a: " + "[" * 200,
    "--- a\n--- b",
    "a: \x01",
    "- !!python/name:os.system x",
)


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("references", [True, False])
def test_both_parsers_read_alike(text: str, references: bool) -> None:
    read = []
    for loader in (_Loader, _PythonLoader):
        try:
            read.append(_load(loader(text, references=references)))
        except yaml.YAMLError:
            read.append("invalid")
    assert read[0] == read[1]


def test_what_the_fast_parser_refuses_is_read_by_the_other() -> None:
    text = "%YAML 1.3\n---\na: 1"
    with pytest.raises(yaml.YAMLError):
        _load(_Loader(text, references=True))
    assert load_yaml(text, references=True) == {"a": 1}
    with pytest.raises(yaml.YAMLError, match="special characters are not allowed"):
        load_yaml("a: \ud800", references=True)
