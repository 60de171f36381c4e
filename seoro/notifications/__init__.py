"""Notifications: one POST of JSON to each URL of the user at the end of runs, campaigns and tests.

`addresses.py` checks and redacts URLs, `message.py` makes the content, and `delivery.py` sends it.
"""
