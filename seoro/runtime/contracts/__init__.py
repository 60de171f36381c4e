"""Contracts between the runtime and its observers, modifiers and backends.

A backend implements `backends.Backend` and the protocols of the other modules that it supports; an action names
the protocol that it needs. Contracts import only data: `seoro.runtime.verdict`.
"""
