"""Says what is installed here, and checks the way from here to an executor and its robots, hop by hop.

`findings.py` is what is found, `installed.py` looks here, `endpoint.py` looks whether anything answers at an
endpoint, `path.py` goes the way to executors, and `lab.py` that to a lab, from here and from executors; `nodes.py`
and `robots.py` have the words for what is there. Nothing here prints.
"""
