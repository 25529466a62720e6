"""How the cases of a study are run and kept: batches, workers, retries, shards."""
