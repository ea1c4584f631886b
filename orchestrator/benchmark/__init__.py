"""Sweeps: every controller in every scenario of a suite, on all cores or a cluster; stopped and resumed at will."""
