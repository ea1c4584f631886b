"""Suites: folders of frozen scenario files, and what writes them."""
