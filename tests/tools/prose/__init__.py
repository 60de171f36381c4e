"""A check of the prose of the project: `python -m tests.tools.prose [PATH ...]`."""
