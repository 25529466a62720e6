"""Engine: batches of cases on the device; the only package that launches kernels."""
