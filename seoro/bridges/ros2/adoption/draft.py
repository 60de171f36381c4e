"""Draft of a profile: its values, their sources, and open questions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from seoro.files.commented_yaml import Place

CHECK: Final = "CHECK"  # marks values that nothing in the system states
Value = float | str


@dataclass(frozen=True)
class Question:
    """Question about something that the system does not state.

    Attributes:
        text: The question, with the unit.
        default: Default answer; its type is that of answers.
        fill: Returns the values that an answer determines, by their places.
        noted: Place of the note, if it is not that of each value.
    """

    text: str
    default: Value
    fill: Callable[[Any], Mapping[Place, Any]]
    noted: Place | None = None


@dataclass
class Draft:
    """Draft of a profile.

    Attributes:
        notes: Sources of values, by place.
        questions: Open questions; until they are answered, the values have the defaults.
        remarks: Remarks on the robot as a whole.
    """

    notes: dict[Place, str] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    _values: dict[str, Any] = field(default_factory=dict)

    @property
    def values(self) -> Mapping[str, Any]:
        """Values, as the content of a profile."""
        return self._values

    def put(self, place: Place, value: Any, note: str = "") -> None:
        """Set a value, with a note on its source."""
        inner = self._values
        for key in place[:-1]:
            inner = inner.setdefault(key, {})
        inner[place[-1]] = value
        if note:
            self.notes[place] = note

    def ask(self, text: str, default: Value, place: Place) -> None:
        """Add a question whose answer is the value of a place."""
        self.add(Question(text, default, lambda answer: {place: answer}))

    def add(self, question: Question) -> None:
        """Add a question, and set the values to its default."""
        self.questions.append(question)
        self._fill(question, question.default, f"{CHECK}: {question.text}, which is not visible in the system")

    def answer(self, question: Question, answer: Value) -> None:
        """Set the values that an answer determines."""
        self.questions.remove(question)
        self._fill(question, answer, f"{question.text}, as answered when this file was written")

    def _fill(self, question: Question, answer: Value, note: str) -> None:
        values = question.fill(answer)
        for place, value in values.items():
            self.put(place, value)
        for place in values if question.noted is None else (question.noted,):
            self.notes[place] = note
