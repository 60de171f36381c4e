"""Command line: the only package that parses arguments, prints or exits.

A module `NAME_command` has the options and the `run` function of the command NAME; `main` imports only that of the
chosen command. `run` returns the exit status, or None for success; it may be a coroutine function. Modules
`*_arguments` declare options that several commands have. May import every other package.
"""
