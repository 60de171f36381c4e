"""Choice of values: immediately for plain structures, by constraint solving for others.

The function in a `Request` evaluates expressions. The folder imports values, functions and instances.
"""
