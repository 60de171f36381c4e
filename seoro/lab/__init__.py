"""Lab files: which simulator or robot serves which actor of a run.

`schema.py` is the form of the file, `reading.py` reads it, `opening.py` starts and connects what it names.
"""
