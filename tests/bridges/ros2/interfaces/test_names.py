"""Names of interfaces, and folders of users."""

from pathlib import Path

import pytest

from seoro.bridges.ros2.interfaces import InvalidDefinition, TypeStore, UnknownInterface
from seoro.errors import UsageError
from tests.bridges.ros2.interfaces.folders import make_folder, store_with


@pytest.fixture(scope="module")
def store() -> TypeStore:
    return TypeStore.bundled()


@pytest.mark.parametrize(
    ("written", "canonical"),
    [
        ("std_msgs/msg/String", "std_msgs/msg/String"),
        ("std_msgs.msg.String", "std_msgs/msg/String"),
        ("std_msgs::msg::String", "std_msgs/msg/String"),
        ("std_msgs/String", "std_msgs/msg/String"),
        (" std_msgs.String ", "std_msgs/msg/String"),
        ("std_srvs/Trigger", "std_srvs/srv/Trigger"),
        ("std_srvs/Trigger_Request", "std_srvs/srv/Trigger_Request"),
        ("nav2_msgs.action.NavigateToPose_SendGoal_Request", "nav2_msgs/action/NavigateToPose_SendGoal_Request"),
        ("nav2_msgs/NavigateToPose", "nav2_msgs/action/NavigateToPose"),
    ],
)
def test_short_names_have_a_canonical_form(store: TypeStore, written: str, canonical: str) -> None:
    assert store.canonical(written) == canonical


@pytest.mark.parametrize(
    ("written", "problem", "near"),
    [
        ("std_msgs/msg/Strin", "package `std_msgs` has no `msg/Strin`", "`std_msgs/msg/String`"),
        ("std_msg/msg/String", "unknown package `std_msg`", "`std_msgs`"),
        ("Pose", "'Pose' is an invalid interface name", "`geometry_msgs/msg/Pose`"),
        ("geometry_msgs/msg/Pose/x", "invalid interface name", ""),
        ("", "invalid interface name", ""),
        ("nav_msgs/msg/pose", "has no `msg/pose`", ""),
        ("other_msgs/msg/Thing", "unknown package `other_msgs`", "--interfaces DIR` of `seoro ros`"),
        ("std_srvs/srv/Trigger_Goal", "`std_srvs/srv/Trigger` has no `_Goal`", "`Trigger_Request`"),
    ],
)
def test_unknown_names_are_refused_with_similar_ones(
    store: TypeStore, written: str, problem: str, near: str
) -> None:
    with pytest.raises(UnknownInterface) as raised:
        store.canonical(written)
    assert problem in str(raised.value)
    assert near in raised.value.help


def test_an_ambiguous_name_is_refused_with_its_full_names(tmp_path: Path) -> None:
    store = store_with(tmp_path, Map_msg="int8 x", Map_srv="---\n")
    with pytest.raises(UnknownInterface, match="is ambiguous") as raised:
        store.canonical("my_robot/Map")
    assert raised.value.help == "write my_robot/msg/Map or my_robot/srv/Map"


def test_a_package_of_the_user_replaces_a_bundled_one(tmp_path: Path) -> None:
    make_folder(tmp_path, Trigger_srv="int8 how\n---\n")
    (tmp_path / "my_robot").rename(tmp_path / "std_srvs")
    bundled = TypeStore.bundled()
    store = bundled.add_folder(tmp_path)
    assert [field.name for field in store.structure("std_srvs/srv/Trigger_Request").fields] == ["how"]
    assert bundled.structure("std_srvs/srv/Trigger_Request").fields == ()
    with pytest.raises(UnknownInterface, match=f"it is defined by {tmp_path / 'std_srvs'}"):
        store.canonical("std_srvs/srv/SetBool")


def test_names_of_interfaces_are_listed_in_order(tmp_path: Path) -> None:
    names = store_with(tmp_path, Grip_srv="---\n", Pose_msg="").names()
    assert [name for name in names if name.startswith("my_robot/")] == ["my_robot/msg/Pose", "my_robot/srv/Grip"]
    assert names == tuple(sorted(names))


def test_an_unknown_member_type_is_reported_with_file_and_line(tmp_path: Path) -> None:
    store = store_with(tmp_path, Grip_msg="int8 a\n\ngeometry_msgs/Poin b")
    with pytest.raises(InvalidDefinition) as raised:
        store.type_hash("my_robot/msg/Grip")
    file = tmp_path / "my_robot" / "msg" / "Grip.msg"
    assert str(raised.value).startswith(f"{file}:3: unknown type of `b`: package `geometry_msgs`")
    assert "`geometry_msgs/msg/Point`" in raised.value.help


def test_an_unknown_type_of_a_nested_member_is_reported(tmp_path: Path) -> None:
    store = store_with(tmp_path, A_msg="B b", B_msg="C[] c", C_msg="D d")
    with pytest.raises(InvalidDefinition, match=r"C\.msg:1: unknown type of `d`"):
        store.structure("my_robot/msg/A")


def test_structures_that_contain_themselves_are_refused(tmp_path: Path) -> None:
    store = store_with(tmp_path, A_msg="B[] b", B_msg="A a")
    with pytest.raises(InvalidDefinition, match="contains itself") as raised:
        store.encode("my_robot/msg/A", {})
    assert raised.value.help == "my_robot/msg/A -> my_robot/msg/B -> my_robot/msg/A"


def test_the_nesting_of_structures_has_a_limit(tmp_path: Path) -> None:
    files = {f"T{level}_msg": f"T{level + 1} t" for level in range(40)}
    store = store_with(tmp_path, **files, T40_msg="int8 x")
    with pytest.raises(InvalidDefinition, match="more than 32 nested structures"):
        store.structure("my_robot/msg/T0")


def test_folders_without_packages_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="folder of interface packages not found"):
        TypeStore.bundled().add_folder(tmp_path / "missing")
    package = make_folder(tmp_path / "share", Pose_msg="") / "my_robot"
    with pytest.raises(UsageError, match="no interfaces found") as raised:
        TypeStore.bundled().add_folder(package)
    assert raised.value.help.endswith(f"this is a package, so give {tmp_path / 'share'}")
    with pytest.raises(UsageError, match="no interfaces found") as raised:
        TypeStore.bundled().add_folder(tmp_path)
    assert "PACKAGE/msg/NAME.msg" in raised.value.help
    (tmp_path / "MyRobot" / "msg").mkdir(parents=True)
    (tmp_path / "MyRobot" / "msg" / "Pose.msg").touch()
    with pytest.raises(InvalidDefinition, match="invalid name of a package or interface"):
        TypeStore.bundled().add_folder(tmp_path)


def test_definition_files_without_utf_8_text_are_refused(tmp_path: Path) -> None:
    store = store_with(tmp_path, Pose_msg="")
    (tmp_path / "my_robot" / "msg" / "Pose.msg").write_bytes(b"int8 \xff")
    with pytest.raises(InvalidDefinition, match="expected UTF-8 text"):
        store.structure("my_robot/msg/Pose")


def test_unknown_distributions_are_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match="'noetic'") as raised:
        TypeStore.bundled("noetic")
    assert "jazzy" in str(raised.value)
