"""Import of RoboVAST files (`.vast`) as campaign files."""
