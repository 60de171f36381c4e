"""Chaos: a real lab under random faults, and an oracle that finds violations of the documented guarantees.

`plan.py` draws a round from a seed. `stage.py` has the processes and links of the lab, `client.py` is a client
process. `play.py` plays a round and collects observations, which `oracle.py` judges. `python -m tests.chaos` plays
batches of rounds and records each in a journal, by which an interrupted batch is resumed.
"""
