"""The behaviors of the language: one construct, one file."""
