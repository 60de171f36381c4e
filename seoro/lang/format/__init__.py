"""The formatter, after the standard's coding style guide (9.2.2), and PEP 8 where that is silent (9.2.5).

It works on the tokens of a file, since the tree knows neither comments nor line breaks: `lines.py` reads logical
lines with their comments, `roles.py` tells what each token is for, `elements.py` finds the brackets, `layout.py`
breaks lines that are too long, `formatter.py` puts them together, and `verify.py` makes sure that nothing but the
layout changed.
"""
