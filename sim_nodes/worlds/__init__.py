"""Worlds as YAML files, and the loader that validates them."""
