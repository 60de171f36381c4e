"""Implementations of the runtime's contracts over Zenoh."""
