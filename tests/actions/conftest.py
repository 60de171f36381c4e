"""Scenarios on the virtual clock, as for the tests of the runtime."""

from tests.runtime.conftest import prepare_text, run_text

__all__ = ["prepare_text", "run_text"]
