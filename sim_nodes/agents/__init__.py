"""People and carts: agents of a world that move by themselves."""
