"""Derives declarations of robots from their models: pure functions of canonical URDF."""
