"""Reading, filtering, printing, summarising and converting recorded traces.

Records are plain data from the files. Imports nothing of the runtime.
"""
