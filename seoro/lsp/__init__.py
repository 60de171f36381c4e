"""The language server: what editors ask of scenario files, answered over the Language Server Protocol.

`server.py` has the features, `scheduling.py` says when texts are checked, `analysis.py` does it; the other modules
answer one question each from an analysis, and know nothing of the server.
"""
