"""Documentation of libraries: their declarations with types, units, defaults and meanings, as data and as text."""
