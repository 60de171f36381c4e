"""Choice of values: immediately for plain structures, by constraint solving for others.

The caller passes the function that evaluates expressions. The folder imports values, functions and instances.
"""
