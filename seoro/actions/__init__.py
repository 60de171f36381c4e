"""Python implementations of seoro's own libraries: one module per `.osc` file with actions.

They use only the contracts of the runtime: the backend of an actor decides how an action is carried out.
"""
