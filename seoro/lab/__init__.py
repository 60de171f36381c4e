"""Labs: files that assign simulators and robots to actors, and commands to the nodes of a lab.

`Lab` is a lab file that was read by `schema`. `open_lab` starts and connects its nodes for a run, with robots that
`binding` assigns, after `waiting` for busy ones; `teardown` follows the run. `status`, `probes` and `commands`
show and control the nodes without a run. May import the bridges, security and runtime.
"""
