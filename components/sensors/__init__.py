"""The sensors: what a robot sees of the crowd."""
