"""Says what is installed here, and checks the way from here to an executor and its robots, hop by hop.

`findings.py` is what is found, `installed.py` looks here, `endpoint.py` looks whether anything answers at an
endpoint, and `path.py` goes the way beyond it. Nothing here prints.
"""
