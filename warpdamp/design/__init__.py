"""Design: from a structure and a target to a damper, with the probability that it does the job."""
