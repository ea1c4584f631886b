"""The orchestrator: reads the scenario, starts, wires, ticks, watches and records."""
