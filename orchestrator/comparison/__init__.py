"""Controllers compared: from the tables of a sweep to statistics, claims, figures and a page."""
