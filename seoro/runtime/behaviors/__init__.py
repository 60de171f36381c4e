"""Behaviors of the language: one construct per module."""
