"""Studies, from a configuration to a Dataset."""
