"""Server of robots as a node, shared by all bridges to robots.

`node.py` serves the verbs, `watchdog.py` stops the robots of lost holders, `work.py` runs goals and watches,
`event_log.py` keeps events, and `robot.py` declares the interface of robots. `admission.py`, `answering.py` and
`emergency.py` also serve executors and simulators. May import `leasing`, `session`, `wire` and `seoro.security`.
"""
