"""A structure that answers its particles step by step: forces, runs, and what an experimenter would read off them."""
