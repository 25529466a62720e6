"""A sweep: run a YAML in which a scalar is a list, and keep the Dataset.

python scripts/sweep_friction.py [CONFIG] [FILE.nc]
"""

import sys
from pathlib import Path

import warpdamp
from warpdamp.analysis.results import write

if __name__ == "__main__":
    config = Path(sys.argv[1] if len(sys.argv) > 1 else "configs/friction.yaml")
    target = Path(sys.argv[2] if len(sys.argv) > 2 else "results/friction.nc")
    dataset = warpdamp.run(config, report=lambda stage, done: print(f"{stage} {done:.0%}", flush=True))
    target.parent.mkdir(parents=True, exist_ok=True)
    write(dataset, target)
    print(dataset["damping_ratio" if "damping_ratio" in dataset else "effectiveness"])
