"""The order of the work, from a configuration to a Dataset."""
