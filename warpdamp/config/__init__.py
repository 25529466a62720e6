"""YAML in, SI out: validated models of a configuration, and the scenes that they describe."""
