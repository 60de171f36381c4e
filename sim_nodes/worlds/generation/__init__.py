"""Worlds from parameters and a seed: rooms, mazes and fields of obstacles, with a way for a robot."""
