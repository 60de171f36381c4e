"""What seoro's own libraries do: one module for each `.osc` file in `seoro.lang.library` with actions.

They are written against the contracts of the runtime, so that where an actor lives decides how an action is
carried out.
"""
