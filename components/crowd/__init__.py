"""The crowd: people who walk."""
