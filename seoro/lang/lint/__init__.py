"""Lints: warnings about valid code that is probably a mistake.

`words.py` reads texts, `names.py` finds names that nothing uses, and `flow.py` follows behaviors. `noqa.py` has
suppression by comments, and `fixes.py` safe fixes. `linter.py` is the entry point.
"""
