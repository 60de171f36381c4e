"""Server of the Model Context Protocol: agents list, check, explain, compare and, if allowed, run scenarios.

`server.py` serves the tools over stdin and stdout. `reading.py` and `results.py` have the tools that only read,
`running.py` the one that runs. Python of users is never imported into the server: runs are processes of their own.
"""
