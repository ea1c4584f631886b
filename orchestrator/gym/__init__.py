"""The Gymnasium environment on top of a session; `crowdcosim.gym` registers it."""
