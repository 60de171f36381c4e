"""Executors, as clients reach them: what is said (`messages.py`), where they are and finding them (`addresses.py`,
`finding.py`), and asking again when the connection was lost (`asking.py`).
"""
