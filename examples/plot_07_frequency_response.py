"""
Frequency response at constant Gamma
====================================

The accelerance of the beam at the damper, for several amplitudes of the motion there: the damper is a complex mass that
depends on frequency and Gamma. Its real part shifts the natural frequency, its imaginary part damps.
"""

from pathlib import Path

import warpdamp
from warpdamp.report.frf import families

DOCS = Path("../docs")  # seen from examples/
results = warpdamp.open_results(DOCS / "beam.nc")
response = warpdamp.accelerance(results, gamma=[1.0, 2.0, 3.0, 6.0, 10.0])
figure = families(response)

# %%
# What an experimenter would fit to these curves, beside natural frequency and damping of the linearised structure.

fitted = warpdamp.fits(response).sel(mode=1)
for gamma in (2.0, 6.0):
    own = 100 * float(response["resonance_damping_ratio"].sel(gamma=gamma, mode=1))
    print(f"Gamma {gamma:g}: {own:.3f} % by the model")
    for fit in fitted["fit"].values:
        print(f"    {fit:<15} {100 * float(fitted['fitted_damping_ratio'].sel(gamma=gamma, fit=fit)):.3f} %")
