"""Debug Adapter Protocol: scenarios in the debuggers of editors, such as VS Code.

`Connection` reads and writes messages, `Session` answers requests, `Views` describes a paused run, and
`RunControl` runs one scenario with a debugger.
"""
