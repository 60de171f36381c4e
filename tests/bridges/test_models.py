"""Looking up models by name."""

from pathlib import Path

import pytest

from seoro.bridges.models import ModelNotFound, ModelPath


def test_seoro_has_the_box_of_the_published_example() -> None:
    assert "<sdf" in ModelPath().read("example_simulation://models/box.sdf")


def test_folders_of_the_user_come_first(tmp_path: Path) -> None:
    model = tmp_path / "example_simulation" / "models" / "box.sdf"
    model.parent.mkdir(parents=True)
    model.write_text("mine")
    assert ModelPath([tmp_path / "empty", tmp_path]).read("example_simulation://models/box.sdf") == "mine"


def test_a_file_can_be_named_directly(tmp_path: Path) -> None:
    (tmp_path / "my box.sdf").write_text("boxed")
    assert ModelPath().read(f"file://{tmp_path}/my%20box.sdf") == "boxed"


def test_an_unknown_model_says_where_was_looked(tmp_path: Path) -> None:
    with pytest.raises(ModelNotFound, match=f"no model 'shop://shelf.sdf'; looked at {tmp_path}/shop/shelf.sdf"):
        ModelPath([tmp_path]).read("shop://shelf.sdf")


@pytest.mark.parametrize("uri", ["shop://../../secret", "shop://a/../../../secret", "shop://%2e%2e/%2e%2e/secret"])
def test_a_path_does_not_leave_its_folder(tmp_path: Path, uri: str) -> None:
    (tmp_path / "secret").write_text("secret")
    with pytest.raises(ModelNotFound, match="leaves the folder"):
        ModelPath([tmp_path / "models"]).read(uri)


@pytest.mark.parametrize("uri", ["box.sdf", "://box.sdf", "shop://", "shop:/box.sdf"])
def test_what_names_no_model_is_told_the_form(uri: str) -> None:
    with pytest.raises(ModelNotFound, match="write `name://path`"):
        ModelPath().read(uri)


def test_too_large_a_model_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "big.sdf").open("wb") as file:
        file.truncate(5 << 20)
    with pytest.raises(ModelNotFound, match="larger than 4 MiB"):
        ModelPath().read(f"file://{tmp_path}/big.sdf")
