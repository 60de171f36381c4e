"""YAML of models with comments."""

from __future__ import annotations

from collections.abc import Mapping

import yaml
from pydantic import BaseModel, Field

from seoro.files.commented_yaml import commented_yaml, described_arguments


class Wheel(BaseModel):
    """Wheel.

    Args:
        radius: Radius
            of the tyre [m].
    """

    radius: float
    spokes: int = 12


class Cart(BaseModel):
    """Cart, with `Args` in no other place.

    Args:
        wheels: Wheels by name.
        name: Name.
    """

    wheels: Mapping[str, Wheel]
    name: str = Field("", alias="as")
    size: tuple[float, ...] = ()
    unset: str = "default"


def test_values_are_written_with_meanings_and_notes() -> None:
    wheels = {"left": Wheel(radius=0.1), "right": Wheel(radius=0.2, spokes=3)}
    cart = Cart.model_validate({"wheels": wheels, "as": "yes", "size": (1.0, 2.0)})
    text = commented_yaml(
        cart, {("as",): "from a label", ("wheels", "right", "spokes"): "counted"}, "A cart.\n  $ run it"
    )
    assert text == (
        "# A cart.\n"
        "#   $ run it\n"
        "# Wheels by name.\n"
        "wheels:\n"
        "  left:\n"
        "    # Radius of the tyre [m].\n"
        "    radius: 0.1\n"
        "  right:\n"
        "    radius: 0.2\n"
        "    # counted\n"
        "    spokes: 3\n"
        "# Name.\n"
        "# from a label\n"
        "as: 'yes'\n"
        "size: [1.0, 2.0]\n"
    )
    assert Cart.model_validate(yaml.safe_load(text)) == cart


def test_long_comments_are_wrapped() -> None:
    text = commented_yaml(Wheel(radius=1.0), {("radius",): "word " * 50}, "heading")
    assert max(map(len, text.splitlines())) <= 100
    assert text.count("word") == 50


def test_classes_without_arguments_have_no_descriptions() -> None:
    assert described_arguments("Wheel.") == {}
