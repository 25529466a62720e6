"""An analysis: open a Dataset, draw it, and find how the optimum depends on a swept scalar.

python scripts/best_friction.py [FILE.nc] [SCALAR]
"""

import sys
from pathlib import Path

import warpdamp

if __name__ == "__main__":
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "results/friction.nc")
    scalar = sys.argv[2] if len(sys.argv) > 2 else "friction"
    dataset = warpdamp.open_results(path)
    warpdamp.draw(dataset).savefig(path.with_suffix(".png"))

    optima = dataset.damper.optimum("damping_ratio" if "damping_ratio" in dataset else "effectiveness")
    columns = [name for name in optima if name.startswith("gamma_")]
    for value in dataset[scalar].values:
        print(f"{scalar} {value:g}")
        print(optima[columns].sel({scalar: value}).to_dataframe()[columns].to_string())

    best = dataset["effectiveness"].where(dataset["effectiveness"] == dataset["effectiveness"].max(), drop=True)
    print("best of all:", {name: best[name].values.item() for name in best.dims}, f"{float(best.max()):.3f}")
