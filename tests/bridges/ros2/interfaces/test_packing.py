"""Packed definition files, and schemas as text."""

import subprocess
import sys
from pathlib import Path

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.packages import DATA, bundled_package
from seoro.bridges.ros2.interfaces.packing import pack
from seoro.bridges.ros2.interfaces.registry import Registry
from seoro.errors import UsageError
from tests.bridges.ros2.interfaces.folders import store_with


def test_packing_a_packed_package_again_changes_nothing() -> None:
    files = sorted(DATA.glob("*/*.interfaces"))
    assert {file.parent.name for file in files} == {"editions", "humble", "jazzy"}
    for file in files:
        package = file.stem.partition("-")[0]
        assert pack(package, Registry({package: bundled_package(file)})) == file.read_text(encoding="utf-8")


def test_packed_definitions_equal_the_read_ones(tmp_path: Path) -> None:
    fields = 'float32[2] f [1.0, 2.5]\nbool[<=2] b [true]\nstring<=3[] s ["a,b"]\n'
    store = store_with(tmp_path, A_msg=f'# c\n{fields}\nint8 X = -3 # d\nstring Y="a \\"b"')
    assert store.schema("my_robot/msg/A") == f'int8 X=-3\nstring Y="a \\"b"\n{fields}'


def test_a_schema_contains_each_referenced_type_once(tmp_path: Path) -> None:
    store = store_with(tmp_path, A_msg="B b\nC c", B_msg="C[] c", C_msg="int8 x")
    ruler = "=" * 80
    assert store.schema("my_robot/A") == (
        f"my_robot/B b\nmy_robot/C c\n{ruler}\nMSG: my_robot/B\nmy_robot/C[] c\n{ruler}\nMSG: my_robot/C\nint8 x\n"
    )


def test_messages_without_rosbags_are_refused_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "seoro.bridges.ros2.interfaces.codec", None)
    with pytest.raises(UsageError, match="messages of ROS 2 need") as raised:
        TypeStore.bundled().encode("std_msgs/String", {})
    assert raised.value.help == "install it with: pip install 'seoro[ros2]'"


def test_names_and_hashes_need_neither_numpy_nor_rosbags() -> None:
    program = (
        "import sys; from seoro.bridges.ros2.interfaces import TypeStore; "
        "TypeStore.bundled().type_hash('std_msgs/String'); "
        "print({'numpy', 'rosbags'} & set(sys.modules))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout == "set()\n"
