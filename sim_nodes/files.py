"""World files and files that they name, such as models, floor plans and declarations of robots."""

from seoro.yaml_files import FileError, Lines, problems, read_text, read_yaml

__all__ = ["NAME", "FileError", "Lines", "problems", "read_text", "read_yaml"]

NAME = r"^[A-Za-z][A-Za-z0-9_-]{0,63}$"
"""What names entities and the parts of robots that are asked for by name."""
