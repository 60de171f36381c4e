"""Traces after the run: reading, filtering, showing, summarising and converting them.

Records are plain data here, as they stand in the files; nothing of the runtime is needed to look at them.
"""
