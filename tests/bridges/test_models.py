"""Looking up models by name."""

from pathlib import Path

import pytest

from seoro.bridges.models import ModelNotFound, ModelPath


def test_the_box_of_the_published_example_is_bundled() -> None:
    assert "<sdf" in ModelPath().read("example_simulation://models/box.sdf").text


def test_models_of_the_user_precede_bundled_ones(tmp_path: Path) -> None:
    model = tmp_path / "example_simulation" / "models" / "box.sdf"
    model.parent.mkdir(parents=True)
    model.write_text("mine")
    assert ModelPath([tmp_path / "empty", tmp_path]).read("example_simulation://models/box.sdf").text == "mine"


def test_a_model_can_be_a_file_uri(tmp_path: Path) -> None:
    (tmp_path / "my box.sdf").write_text("boxed")
    assert ModelPath().read(f"file://{tmp_path}/my%20box.sdf").text == "boxed"


def test_an_unknown_model_is_reported_with_the_searched_folders(tmp_path: Path) -> None:
    with pytest.raises(
        ModelNotFound, match=f"unknown model 'shop://shelf.sdf' .searched: {tmp_path}/shop/shelf.sdf"
    ):
        ModelPath([tmp_path]).read("shop://shelf.sdf")


@pytest.mark.parametrize("uri", ["shop://../../secret", "shop://a/../../../secret", "shop://%2e%2e/%2e%2e/secret"])
def test_a_model_path_out_of_its_folder_is_refused(tmp_path: Path, uri: str) -> None:
    (tmp_path / "secret").write_text("secret")
    with pytest.raises(ModelNotFound, match="leads out of the folder"):
        ModelPath([tmp_path / "models"]).read(uri)


@pytest.mark.parametrize("uri", ["box.sdf", "://box.sdf", "shop://", "shop:/box.sdf"])
def test_an_invalid_model_uri_is_refused_with_the_expected_form(uri: str) -> None:
    with pytest.raises(ModelNotFound, match="expected `name://path`"):
        ModelPath().read(uri)


def test_a_too_large_model_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "big.sdf").open("wb") as file:
        file.truncate(5 << 20)
    with pytest.raises(ModelNotFound, match="larger than 4 MiB"):
        ModelPath().read(f"file://{tmp_path}/big.sdf")
