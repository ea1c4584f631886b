"""The controllers: from observations to commands."""
