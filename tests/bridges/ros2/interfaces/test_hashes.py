"""Type hashes compared with the official ones."""

import json
from pathlib import Path

import pytest

from seoro.bridges.ros2.interfaces import TypeStore, UnknownInterface
from tests.bridges.ros2.interfaces.folders import make_folder, store_with

GOLDEN: dict[str, str] = json.loads(
    (Path(__file__).parents[3] / "data" / "ros2" / "jazzy_rihs01.json").read_text(encoding="utf-8")
)
# The golden hashes come from a system without geographic_msgs; hashes of types with its poses are missing.
INCOMPLETE = {
    f"nav2_msgs/action/FollowGPSWaypoints{suffix}"
    for suffix in ("", "_Goal", "_SendGoal", "_SendGoal_Event", "_SendGoal_Request")
}


def test_all_hashes_agree_with_the_official_ones() -> None:
    store = TypeStore.bundled()
    compared = {name for name in GOLDEN if not name.startswith("test_msgs/")} - INCOMPLETE
    assert {name: store.type_hash(name) for name in compared} == {name: GOLDEN[name] for name in compared}
    assert len(compared) == 721


def test_interfaces_of_users_have_hashes(tmp_path: Path) -> None:
    times = "builtin_interfaces/Duration duration_value\nbuiltin_interfaces/Time time_value\n"
    make_folder(tmp_path, Builtins_msg=times)
    (tmp_path / "my_robot").rename(tmp_path / "test_msgs")
    store = TypeStore.bundled().add_folder(tmp_path)
    assert store.type_hash("test_msgs/msg/Builtins") == GOLDEN["test_msgs/msg/Builtins"]


def test_defaults_constants_and_comments_do_not_change_a_hash(tmp_path: Path) -> None:
    store = store_with(tmp_path, A_msg="int8 x", B_msg="int8 X=1\nint8 x 5 # five")
    (tmp_path / "my_robot" / "msg" / "A.msg").write_text("int8 x 3\n")
    assert store.type_hash("my_robot/A") == TypeStore.bundled().add_folder(tmp_path).type_hash("my_robot/A")
    assert store.type_hash("my_robot/A") != store.type_hash("my_robot/B")  # its name counts


@pytest.mark.parametrize("suffix", ["", "_SendGoal", "_GetResult_Response", "_FeedbackMessage"])
def test_derived_structures_of_actions_are_known(suffix: str) -> None:
    name = f"nav2_msgs/action/Spin{suffix}"
    assert TypeStore.bundled().type_hash(name) == GOLDEN[name]


@pytest.mark.parametrize("distribution", ["jazzy", "humble"])
def test_all_definitions_refer_to_bundled_definitions(distribution: str) -> None:
    store = TypeStore.bundled(distribution)
    for name in store.names():
        assert store.type_hash(name).startswith("RIHS01_")


def test_another_edition_of_a_package_is_found_by_its_hash() -> None:
    store = TypeStore.bundled()
    name = "simulation_interfaces/srv/SpawnEntity"
    assert store.matching(name, store.type_hash(name)) is store
    humble = TypeStore.bundled("humble")
    found = store.matching(name, humble.type_hash(name))
    assert found is not None
    assert found.type_hash(name) == humble.type_hash(name) != store.type_hash(name)
    assert "uri" in [field.name for field in found.structure(f"{name}_Request").fields]
    assert found.type_hash("nav2_msgs/action/Spin") == store.type_hash("nav2_msgs/action/Spin")
    assert store.matching(name, "RIHS01_" + "0" * 64) is None
    assert store.matching("std_msgs/msg/String", "RIHS01_" + "0" * 64) is None


@pytest.mark.parametrize(
    ("distribution", "result", "feedback"), [("humble", "ecdf", "9d1f"), ("jazzy", "c407", "9d1f")]
)
def test_hashes_of_distributions_differ_with_their_packages(distribution: str, result: str, feedback: str) -> None:
    store = TypeStore.bundled(distribution)
    assert store.type_hash("nav2_msgs/action/NavigateToPose_GetResult").startswith(f"RIHS01_{result}")
    assert store.type_hash("nav2_msgs/action/NavigateToPose_FeedbackMessage").startswith(f"RIHS01_{feedback}")


def test_a_message_has_no_request() -> None:
    with pytest.raises(UnknownInterface, match="no `_Request`"):
        TypeStore.bundled().type_hash("std_msgs/msg/String_Request")


# Computed by rosidl for vision_msgs 4: `get_type_hash` in generated code that others have published.
VISION_MSGS = {
    "Detection2DArray": "214274120007f4a683866481336b70310268cfa107aebe9d594a6acf75bda968",
    "Detection2D": "0d12b69df5c593b3455b7346fac8205437a7d4bcb09b9e0e0b2dde787ded38ea",
    "ObjectHypothesisWithPose": "41c12344c0396c48b81df12467c192d99b2a0eb1463c5c37194e4223251c80bc",
    "BoundingBox2D": "008eacbb0cf8f26e83795547bed013eec3675485ef386ec056d80eaaf1c1ce2f",
    "LabelInfo": "3d37df4015cdf660cc851c51897f2acd957e1ca6205ba0a99aebffb9406b0783",
    "VisionClass": "1e4a11f0fed50b5623cb8ff26ca0e37952a48a9c074d16f804b44e9164c2037a",
}


@pytest.mark.parametrize("distribution", ["jazzy", "humble"])
def test_hashes_of_detections_agree_with_those_of_rosidl(distribution: str) -> None:
    store = TypeStore.bundled(distribution)
    found = {name: store.type_hash(f"vision_msgs/msg/{name}") for name in VISION_MSGS}
    assert found == {name: f"RIHS01_{digits}" for name, digits in VISION_MSGS.items()}
