"""The component families; none imports another."""
