"""The evaluator: metrics of a run."""
