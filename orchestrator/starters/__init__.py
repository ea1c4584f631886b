"""Starting files that `crowdcosim new` writes."""
