"""Variables of the results, with their units and meanings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .kernels.columns import EVERY_LOSS
from .status import Status

if TYPE_CHECKING:
    import xarray as xr

VARIABLES = {
    "energy_dissipated": ("J", "energy dissipated per cycle"),
    "energy_dissipated_standard_error": (
        "J",
        "standard error of the average over cycles of the energy dissipated per cycle",
    ),
    "energy_dissipated_interval": (
        "J",
        "half-width of the 95 % interval of the energy per cycle: averaging, and the state that the bed is in",
    ),
    "degrees_of_freedom": ("1", "of the standard error of the energy dissipated per cycle"),
    "memory_error": ("J", "standard error of the energy per cycle by the state that the bed happens to be in"),
    "discretisation_error": ("J", "error of the energy per cycle by the step, estimated from the ledger's residual"),
    "energy_mean": ("J", "energy dissipated per cycle, mean over packings"),
    "energy_mean_standard_error": ("J", "standard error of the mean: packings, their states, averaging and step"),
    "energy_mean_interval": ("J", "half-width of the 95 % interval of the mean"),
    "packings": ("1", "packings that the mean is over"),
    "within_tolerance": ("1", "whether the mean's standard error is within accuracy.tolerance (1) or not (0)"),
    "effectiveness": ("1", "energy dissipated per cycle over that of the ideal impact damper (eqs 4, 5)"),
    "effectiveness_standard_error": ("1", "standard error of the average over cycles of the effectiveness"),
    **{f"{name}_loss": ("J", f"energy lost per cycle: {what}") for name, what in EVERY_LOSS.items()},
    "work_input": ("J", "work per cycle of the enclosure on the particles"),
    "harmonic_work": ("J", "work per cycle by the first harmonic of the reaction, -pi X Im(F1)"),
    "ledger_residual": ("1", "energy not accounted for, over the energy dissipated"),
    "floor_impulse": ("N s", "normal impulse of the floor per cycle"),
    "lid_impulse": ("N s", "normal impulse of the lid per cycle"),
    "cycle_displacement": ("m", "root mean square displacement of particles over a cycle, less the common one"),
    "apparent_mass": ("kg", "mass that the structure feels, Re(F1) / (w^2 X)"),
    "normalised_damping": ("1", "energy per cycle over 0.5 m_total (Gamma g / w)^2 (eq. 19, square on the speed only)"),
    "clearance": ("m", "travel of the bed's centre of mass between rest on the floor and rest against the lid"),
    "clearance_after": ("m", "clearance after the case, measured in the same way"),
    "packing_fraction": ("1", "volume of the particles over that of the cavity less the clearance"),
    "packing_fraction_after": ("1", "packing fraction after the case"),
    "compaction_blocks": ("1", "blocks of shaking that compacted the bed"),
    "compaction_settled": ("1", "whether the rule that ends the bed's preparation was met (1) or its most blocks (0)"),
    "largest_overlap": ("1", "largest overlap over the reduced radius since the start"),
    "excitation_frequency": ("Hz", "frequency of the excitation"),
    "displacement": ("m", "displacement amplitude X of the enclosure"),
    "cycles": ("1", "cycles run"),
    "cycles_discarded": ("1", "cycles at the start left out of the averages"),
    "steps": ("1", "steps run"),
    "cpu_time": ("s", "processor time"),
    "status": ("1", "how the case ended"),
    "message": ("1", "why the case could not be run; empty where it ran"),
    "particle_mass": ("kg", "mass of all particles"),
    "damping_ratio": ("1", "modal damping ratio (eqs 6-11), mean over seeds"),
    "damping_ratio_standard_error": ("1", "standard error of the modal damping ratio"),
    "natural_frequency": ("Hz", "natural frequency with the particles' mass"),
    "mode_amplitude": ("kg-0.5", "mass-normalised mode shape at the damper"),
    "modal_mass": ("kg", "1 / phi^2 at the damper"),
    # corrected for the mass that the structure feels (modal/apparent_mass.py)
    "apparent_mass_standard_error": ("kg", "standard error of the apparent mass"),
    "quadrature_mass": ("kg", "mass in quadrature m'' = W / (pi w^2 X^2): the complex mass is m' - j m''"),
    "quadrature_mass_standard_error": ("kg", "standard error of the mass in quadrature"),
    "empty_natural_frequency": ("Hz", "natural frequency without the particles"),
    "corrected_natural_frequency": ("Hz", "natural frequency with the particles' apparent mass"),
    "corrected_natural_frequency_standard_error": ("Hz", "standard error of the corrected natural frequency"),
    "corrected_mode_amplitude": ("kg-0.5", "mass-normalised mode shape at the damper, with the apparent mass"),
    "strain_energy": ("J", "largest strain energy of a cycle, the particles taken as rigid (eq. 11)"),
    "corrected_strain_energy": ("J", "largest strain energy of a cycle at the corrected natural frequency"),
    "corrected_damping_ratio": ("1", "modal damping ratio with the corrected strain energy"),
    # frequency response (modal/frf.py)
    "accelerance_real": ("m s-2 N-1", "accelerance at the damper, in phase with the force"),
    "accelerance_imaginary": ("m s-2 N-1", "accelerance at the damper, in quadrature"),
    "resonance_frequency": ("Hz", "natural frequency with the damper linearised at this Gamma"),
    "resonance_damping_ratio": ("1", "damping ratio with the damper linearised at this Gamma"),
    "force": ("N", "amplitude of the force"),
    "branch": ("1", "number of the branch of the response"),
    "response_gamma": ("1", "acceleration amplitude of the response over g"),
    "stable": ("1", "whether the state is stable"),
    "fitted_frequency": ("Hz", "natural frequency fitted to the FRF"),
    "fitted_frequency_standard_error": ("Hz", "standard error of the fitted natural frequency"),
    "fitted_damping_ratio": ("1", "damping ratio fitted to the FRF"),
    "fitted_damping_ratio_standard_error": ("1", "standard error of the fitted damping ratio"),
    "fitted_modal_constant": ("kg-1", "size of the modal constant fitted to the FRF"),
    "fitted_quality": ("1", "coefficient of determination of the fitted FRF in its band"),
    "band_start": ("Hz", "lowest frequency of the band that was fitted"),
    "band_end": ("Hz", "highest frequency of the band that was fitted"),
    "band_lines": ("1", "lines of the FRF in the band that was fitted"),
    # cards (modal/card.py)
    "apparent_mass_interval": ("kg", "half-width of the 95 % interval of the apparent mass"),
    "quadrature_mass_interval": ("kg", "half-width of the 95 % interval of the mass in quadrature"),
    "effectiveness_interval": ("1", "half-width of the 95 % interval of the effectiveness, mean over packings"),
    "within_range": ("1", "whether Gamma lies in the range of the damper's results"),
    "inherent_damping": ("1", "damping ratio without the damper"),
    # several dampers on one structure (study/several.py)
    "damper_gamma": ("1", "acceleration amplitude over g at the damper's own place"),
    "damper_amplitude": ("kg-0.5", "mass-normalised mode shape at each damper, positive"),
    "damper_share": ("1", "what a damper adds to the modal damping ratio"),
    # coupled runs (coupled/results.py)
    "structure_displacement": ("m", "displacement of the enclosure along the excitation, relative to its base"),
    "structure_acceleration": ("m s-2", "acceleration of the enclosure along the excitation, a base's included"),
    "reaction": ("N", "force of the particles on the enclosure along the excitation"),
    "applied_force": ("N", "force on the structure at the damper"),
    "base_acceleration": ("m s-2", "acceleration of the structure's base along the excitation"),
    "force_work": ("J", "work of the force on the structure"),
    "base_work": ("J", "work that the base puts in, as that of the inertial forces in its frame"),
    "force_rms": ("N", "root mean square of the force"),
    "force_rms_asked": ("N", "root mean square of the force as asked for: of a spectrum, from its breakpoints"),
    "base_grms": ("1", "root mean square acceleration of the base over 9.81 m/s^2"),
    "base_grms_asked": ("1", "the same from the spectrum's breakpoints"),
    "response_grms": ("1", "root mean square acceleration of the enclosure over 9.81 m/s^2, second half of the run"),
    "transmissibility_real": ("1", "acceleration of the enclosure over that of the base, in phase"),
    "transmissibility_imaginary": ("1", "acceleration of the enclosure over that of the base, in quadrature"),
    "structure_loss": ("J", "energy lost by the structure's own damping"),
    "particle_loss": ("J", "energy lost in contacts"),
    "closure": ("1", "energy of structure and particles not accounted for, over what was lost"),
    "window_gamma": ("1", "acceleration amplitude over g, of a stretch of the record"),
    "window_frequency": ("Hz", "natural frequency of the mode as it answers in that stretch"),
    "window_steady": ("1", "whether the amplitude is that of the stretch before to 2 % (1) or not (0)"),
    "window_damping_ratio": ("1", "damping ratio, inherent and by the damper, of the mode in that stretch"),
    "predicted_frequency": ("Hz", "natural frequency that the dampers' cards predict at the Gamma of that stretch"),
    "predicted_damping_ratio": ("1", "damping ratio that the dampers' cards predict at the Gamma of that stretch"),
}


NOT_RUN = -1
"""Stands in integer variables for a case that was not run."""


INTEGERS = (
    *("packings", "within_tolerance", "compaction_blocks", "compaction_settled"),
    *("cycles", "cycles_discarded", "steps", "status"),
)


def describe(dataset: xr.Dataset) -> xr.Dataset:
    """Give every variable its units and long name, and ``status`` its meanings."""
    import numpy as np

    for name, variable in dataset.data_vars.items():
        units, long_name = VARIABLES[name]
        variable.attrs.update(units=units, long_name=long_name)
    if "status" in dataset:
        dataset["status"].attrs.update(
            flag_values=np.array([int(s) for s in Status], np.int32),
            flag_meanings=" ".join(s.name.lower() for s in Status),
            comment="; ".join(f"{int(s)}: {s.meaning}" for s in Status),
        )
    return dataset
