"""What ``scripts/benchmarks/benchmark.py`` measures, one subject a file."""
