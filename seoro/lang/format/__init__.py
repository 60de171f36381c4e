"""Formatter by the coding style guide of the standard (9.2.2), else by PEP 8 (9.2.5).

It works on tokens, since the tree has neither comments nor line breaks. `lines.py` reads logical lines with their
comments, `roles.py` classifies tokens, and `elements.py` groups them by brackets. `layout.py` breaks long lines,
`formatter.py` joins all lines, and `verify.py` checks that only the layout has changed.
"""
