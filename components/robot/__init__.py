"""The robot: bodies, drives and contacts."""
