"""Robots by reference: short declarations of models that ship in packages of PyPI."""
