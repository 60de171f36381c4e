"""The command, the runtime and a simulator node together, as users run them."""
