"""Logs: what a run writes, and what can be done with it afterwards."""
