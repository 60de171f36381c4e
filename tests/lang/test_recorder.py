"""Recorders receive names and values of a check."""

from pathlib import Path

from seoro.lang import frontend
from seoro.lang.program import EnumMember
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, Type, TypeSymbol, UnitSymbol
from seoro.lang.types import FLOAT

TEXT = """import osc.types
enum color: [red, green]
struct box:
    paint: color = green
    size: length = 3mm
    half: float = size / 2m
"""


class Notes:
    """Recorded names and values."""

    def __init__(self) -> None:
        self.names: dict[str, object] = {}
        self.types: dict[str, Type] = {}

    def name(self, span: Span, meaning: object) -> None:
        self.names[f"{span.line}:{span.text}"] = meaning

    def value(self, span: Span, type_: Type) -> None:
        self.types[span.text] = type_


def check(folder: Path, text: str) -> Notes:
    path, notes = folder / "test.osc", Notes()
    path.write_text(text, encoding="utf-8")
    frontend.check(frontend.load(path), recorder=notes)
    return notes


def test_names_and_types_are_recorded(tmp_path: Path) -> None:
    notes = check(tmp_path, TEXT)
    member, unit, field = notes.names["4:green"], notes.names["5:mm"], notes.names["6:size"]
    assert isinstance(member, EnumMember) and member.text == "green"
    assert isinstance(unit, UnitSymbol) and unit.factor == 0.001
    assert isinstance(field, FieldSymbol) and field.owner is not None and field.owner.name == "box"
    assert notes.types["size / 2m"] == FLOAT


def test_names_around_a_syntax_error_are_recorded(tmp_path: Path) -> None:
    notes = check(tmp_path, TEXT + "    oops oops\n\nstruct other:\n    box: box\n")
    assert isinstance(notes.names["10:box"], TypeSymbol)
