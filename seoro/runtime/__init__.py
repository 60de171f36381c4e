"""The reactive runtime: from a plan to a trace and a verdict.

It uses plans, contracts and time, but neither syntax nor middleware. Its folders import in one direction:
`kernel`, `values`, `contracts`, `functions`, `trace`, `instances`, `choose`, `expressions`, `parameters`,
`events`, `coverage`, `execution`, `actions`, `explain`, `behaviors`, and then `feasibility`, `accept`, `run.py`.
"""
