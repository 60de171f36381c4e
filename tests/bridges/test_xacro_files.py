"""xacro files: expanded with arguments and packages, within limits, and for trusted files only."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.xacro_files import SWITCH, split_arguments

pytest.importorskip("xacro")

CART = """<robot name="cart" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="length" default="0.4"/>
<xacro:include filename="$(find parts)/urdf/wheel.xacro"/>
<link name="base"><collision><geometry><box size="$(arg length) ${2 * 0.1} 0.1"/></geometry></collision>
<visual><geometry><mesh filename="file://$(find parts)/meshes/hull.stl"/></geometry></visual></link>
<xacro:wheel side="left"/>
</robot>"""
WHEEL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="wheel" params="side">
<link name="${side}_wheel"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>
<joint name="${side}" type="fixed"><parent link="base"/><child link="${side}_wheel"/></joint>
</xacro:macro></robot>"""
MACROS = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    """A file that includes one of another package, whose folder has another name."""
    for name, text in (("cart/cart.urdf.xacro", CART), ("repository/urdf/wheel.xacro", WHEEL)):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "repository/meshes").mkdir()
    (tmp_path / "repository/meshes/hull.stl").write_bytes(b"solid")
    (tmp_path / "parts").symlink_to("repository")
    return tmp_path / "cart" / "cart.urdf.xacro"


def test_macros_arguments_and_packages_are_expanded(cart: Path) -> None:
    found = gather(Path(f"{cart}?length=0.8"), expands=True)
    assert 'size="0.8 0.2 0.1"' in found.text
    assert 'name="left_wheel"' in found.text
    assert 'filename="package://parts/meshes/hull.stl"' in found.text
    assert dict(found.files) == {"package/parts/meshes/hull.stl": b"solid"}
    assert [path.name for path in found.paths] == ["wheel.xacro", "hull.stl"]
    assert 'size="0.4 0.2 0.1"' in gather(cart, expands=True).text


def test_a_package_is_found_by_its_manifest(tmp_path: Path) -> None:
    (tmp_path / "checkout/urdf").mkdir(parents=True)
    (tmp_path / "checkout/package.xml").write_text("<package><name>arm_description</name></package>")
    path = tmp_path / "checkout/urdf/arm.xacro"
    path.write_text(MACROS.format('<link name="$(find arm_description)"/>'))
    assert f'name="{tmp_path}/checkout"' in gather(path, expands=True).text


def test_arguments_follow_the_name() -> None:
    assert split_arguments("a/b.xacro?arm=left&speed=1.5&empty=") == (
        "a/b.xacro",
        {"arm": "left", "speed": "1.5", "empty": ""},
    )
    assert split_arguments("what?.urdf") == ("what?.urdf", {})


def test_only_trusted_files_are_expanded(cart: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InvalidModel, match="is a xacro file, which only"):
        gather(cart)
    with pytest.raises(ModelNotFound, match="is a xacro file, which only"):
        ModelPath().read(f"file://{cart}")
    assert "0.3 0.2" in ModelPath(expands=True).read(f"file://{cart}?length=0.3").text
    monkeypatch.setenv(SWITCH, "off")
    with pytest.raises(InvalidModel, match="not expanded here"):
        gather(cart, expands=True)


def test_included_files_stay_in_the_folders_of_models(cart: Path) -> None:
    with pytest.raises(InvalidModel, match=r"includes .*wheel.xacro, which is outside of the folders"):
        gather(cart, (cart.parent,), expands=True)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("<link", "cannot expand .*not well-formed"),
        ('<link name="$(find none)"/>', "unknown package 'none'.*ROS_PACKAGE_PATH"),
        ('<link name="$(arg none)"/>', "Undefined substitution argument none"),
        ("<link name=\"${open('/etc/passwd').read()}\"/>", "name 'open' is not defined"),
        ("<link name=\"${'a' * 5000000}\"/>", "more than 4194304 characters"),
        ("<link name=\"${'a' * 10**10}\"/>", "MemoryError"),
        ('<xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/>', "recursion"),
    ],
)
def test_invalid_files_are_refused_with_the_reason(tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "r.xacro"
    path.write_text(MACROS.format(content))
    with pytest.raises(InvalidModel, match=words):
        gather(path, expands=True)
