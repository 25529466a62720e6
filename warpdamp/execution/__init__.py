"""Execution of a study's cases: batches, workers, retries, shards."""
