"""JSON Schemas of files and the models of these files agree."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import pytest
from jsonschema import Draft7Validator
from pydantic import BaseModel, ValidationError

from seoro.bridges.ros2.robots.profile import Profile
from seoro.cli.campaign_keys import CampaignKeys
from seoro.cli.main import main
from seoro.executor.limits import Policy
from seoro.files.plain_yaml import load_yaml
from seoro.files.schemas import SCHEMAS, file_name, schema_text
from seoro.lab.schema import LabFile
from sim_nodes.worlds.schema import WorldFile
from tests.tools.code_blocks import blocks_in
from tests.tools.json_schemas import text_of

Content = dict[str, Any]
ROOT: Final = Path(__file__).parents[2]
FILES: Final = {
    "campaign": ("scenarios/experiments/*.yaml",),
    "lab": ("scenarios/multi_robot/labs/*.yaml",),
    "policy": (),
    "profile": ("seoro/bridges/ros2/robots/profiles/*.yaml",),
    "robot": (
        "sim_nodes/robots/*.yaml",
        "sim_nodes/robots/references/*.yaml",
        "scenarios/sensors/worlds/spotter.yaml",
        "examples/workshop/cart.yaml",
    ),
    "world": (
        "sim_nodes/worlds/*.yaml",
        "scenarios/catalogue/worlds/*.yaml",
        "scenarios/sensors/worlds/yard.yaml",
        "examples/workshop/workshop.yaml",
    ),
}
MODELS: Final[dict[str, type[BaseModel]]] = {
    "campaign": CampaignKeys, "lab": LabFile, "policy": Policy, "profile": Profile, "world": WorldFile,
}  # fmt: skip
HALL: Final = {"name": "hall", "extent": [0, 0, 5, 5]}
BASE: Final = {"limits": {"linear": 0.5, "angular": 1.0}}
HOME: Final = {"home": {"x": 0, "y": 0}}
BAG: Final = {"kind": "bag", "bag": "field"}
RULED: Final[Sequence[tuple[str, Content, Sequence[Content]]]] = (  # kind, valid file, invalid files
    (
        "lab",
        {"simulators": {"hall": {"simulator": "mujoco"}}, "robots": {"one": {"in": "hall"}}},
        [
            {"simulators": {"hall": {}}},
            {"simulators": {"hall": {"simulator": "mujoco", "name": "hall"}}},
            {"simulators": {"hall": {"simulator": "mujoco", "connect": "tcp/127.0.0.1:7450"}}},
            {"robots": {"one": {}}},
            {"robots": {"one": {"in": "hall", "namespace": "/one"}}},
        ],
    ),
    (
        "lab",
        {"robots": {"one": BAG}},
        [
            {"robots": {"one": {"kind": "bag"}}},
            {"robots": {"one": {"bag": "field"}}},
            {"robots": {"one": {**BAG, "in": "hall"}}},
            {"robots": {"one": {**BAG, "limits": {}}}},
        ],
    ),
    (
        "lab",
        {"simulators": {"hall": {"simulator": "mujoco"}}, "robots": {"one": {"in": "hall", "after": HOME}}},
        [
            {"robots": {"one": {"in": "hall", "after": {**HOME, "scenario": "back.osc"}}}},
            {"robots": {"one": {"in": "hall", "after": {"within": 3}}}},
        ],
    ),
    (
        "profile",
        {"model": "a", "kinds": ["robot"], "base": BASE},
        [{"base": None}, {"sensors": {"sight": {"cups": {"topic": "a", "width": 640}}}}],
    ),
    (
        "world",
        {"name": "a", "generate": {"maze": {}}},
        [{"generate": {}}, {"generate": {"maze": {}, "rooms": {}}}],
    ),
    (
        "world",
        {**HALL, "people": [{"name": "a", "wander": [0, 0, 1, 1]}]},
        [{"people": [{"name": "a", "wander": [0, 0, 1, 1], "walk": {"points": [[1, 1]]}}]}],
    ),
)
POLICY: Final = {"everybody": {"commands": 10.0}, "roles": {"viewer": {"allow": ["files"]}}}
WRONG: Final = {
    "campaign": ({}, {"scenario": 3}, {"scenario": "a.osc", "simulator": {"nome": "mujoco"}}),
    "lab": ({"robots": {"one": {"inn": "hall"}}}, {"robots": {"1 2": {"in": "hall"}}}, {"robots": []}),
    "policy": ({"everybody": {"sandbox": "sometimes"}}, {"everybody": {"running": 0}}),
    "profile": ({"model": "a"}, {"model": "A B", "kinds": ["robot"]}, {"model": "a", "kinds": []}),
    "world": (
        {"name": "hall", "extent": [0, 0, 5]},
        {"name": "hall", "extent": [0, 0, 5, 500]},
        {"name": "hall", "extent": [0, 0, 5, 5], "robots": [{"name": "one"}]},
        {"name": "hall", "extent": [0, 0, 5, 5], "doors": [{"name": "a", "kind": "trap"}]},
    ),
}


def validator_of(name: str) -> Draft7Validator:
    return Draft7Validator(json.loads(schema_text(name)))


def problems(name: str, content: object) -> list[str]:
    return [error.message for error in validator_of(name).iter_errors(content)]


def contents_of(name: str) -> Iterator[tuple[str, Any]]:
    for pattern in FILES[name]:
        for path in sorted(ROOT.glob(pattern)):
            content = load_yaml(path.read_text(), references=True)
            content.pop("reference", None)  # of robots that come with seoro
            yield path.name, content


@pytest.mark.parametrize("name", SCHEMAS)
def test_schemas_are_those_of_the_models(name: str) -> None:
    assert schema_text(name) == text_of(name), "`make goldens` writes the schemas"
    Draft7Validator.check_schema(json.loads(schema_text(name)))


@pytest.mark.parametrize("name", SCHEMAS)
def test_all_files_of_the_project_are_valid(name: str) -> None:
    found = dict(contents_of(name)) or {"policy": POLICY}
    assert {file: problems(name, content) for file, content in found.items()} == {file: [] for file in found}


@pytest.mark.parametrize("name", SCHEMAS)
def test_unknown_keys_are_errors_at_each_depth(name: str) -> None:
    for file, content in dict(contents_of(name)).items() or {"policy": POLICY}.items():
        assert problems(name, {**content, "unknown": 1}), file
    parts = {"campaign": "simulator", "lab": "robots", "policy": "everybody", "profile": "base", "robot": "mobile"}
    assert problems(name, {parts.get(name, "floor"): {"unknown key": {}}})


@pytest.mark.parametrize(("name", "content"), [(name, each) for name, some in WRONG.items() for each in some])
def test_what_models_refuse_is_refused(name: str, content: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        MODELS[name].model_validate(content)
    assert problems(name, content)


@pytest.mark.parametrize(("name", "valid", "invalid"), RULED)
def test_rules_on_keys_hold_in_models_and_schemas(name: str, valid: Content, invalid: Sequence[Content]) -> None:
    MODELS[name].model_validate(valid)
    assert problems(name, valid) == []
    for change in invalid:
        with pytest.raises(ValidationError, match="Value error"):
            MODELS[name].model_validate({**valid, **change})
        assert problems(name, {**valid, **change}), change


def test_keys_without_a_value_count_as_missing() -> None:
    simulator = {"simulator": "mujoco", "connect": None}
    lab = {"simulators": {"hall": simulator}, "robots": {"one": {"in": "hall", "kind": None, "bag": None}}}
    LabFile.model_validate(lab)
    assert problems("lab", lab) == []


@pytest.mark.parametrize(("page", "name"), [("lab", "lab"), ("worlds", "world"), ("campaign_files", "campaign")])
def test_examples_of_the_documentation_are_valid(page: str, name: str) -> None:
    blocks = [each for each in blocks_in(ROOT / f"docs/how-to/{page}.md") if each.language == "yaml" and each.name]
    required = json.loads(schema_text(name)).get("required", ["robots"])
    contents = [
        content for each in blocks if (content := load_yaml(each.text, references=True)).keys() >= {*required}
    ]
    assert contents
    assert [problems(name, content) for content in contents] == [[] for _ in contents]


def test_partial_values_of_robots_with_a_drive_are_valid() -> None:
    short = {"urdf": "cart.urdf", "drive": "differential", "mobile": {"battery": {"charge": 0.5}}}
    assert problems("robot", short) == []
    assert problems("robot", {**short, "mobile": {"battery": {"charge": 2.0}}})
    assert problems("robot", {**short, "drive": "hover"})


def test_schemas_are_printed_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "world"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "World file of seoro"
    assert main(["schema"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == [*SCHEMAS]
    assert main(["schema", "--output-dir", str(tmp_path / "new")]) == 0
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [file_name(name) for name in SCHEMAS]


def test_unknown_schemas_and_unwritable_folders_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["schema", "wolrd"]) == 2
    assert "did you mean `world`" in capsys.readouterr().err
    (tmp_path / "file").touch()
    assert main(["schema", "-o", str(tmp_path / "file")]) == 2
    assert "cannot write to" in capsys.readouterr().err
