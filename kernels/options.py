"""Options that kernels are compiled with."""

import platform
from pathlib import Path

import warp as wp

LANES = 8
"""Contacts that are computed side by side; see ``lanes.py``."""


def gathers_are_fast() -> bool:
    """Whether this processor gathers the lanes' numbers faster than it loads them one by one.

    Intel's do, unless microcode holds them back against data sampling; AMD's do not.  Where Linux does not say which,
    loads one by one are the smaller loss.
    """
    try:
        described = Path("/proc/cpuinfo").read_text()
        sampling = Path("/sys/devices/system/cpu/vulnerabilities/gather_data_sampling").read_text()
    except OSError:
        return False
    return "GenuineIntel" in described and sampling.startswith("Not affected")


VECTORS = f"-mllvm -force-vector-width={LANES}"
if platform.machine().lower() in ("x86_64", "amd64"):
    VECTORS += " -mprefer-vector-width=512"
    if not gathers_are_fast():
        VECTORS += " -target-feature +prefer-no-gather"
"""Vectors as wide as the lanes, whatever the compiler thinks they cost; and loads one by one where the instruction that
gathers is slow.  How a number is loaded is no part of the results: the bits are the same."""

UNIQUE = {
    "module": "unique",
    "enable_backward": False,
    "module_options": {
        "max_unroll": LANES - 1,  # or the loop over lanes would be none
        "cpu_compiler_flags": f"{wp.config.cpu_compiler_flags} {VECTORS} "
        "-ffp-contract=fast -freciprocal-math -fno-signed-zeros -mreassociate",
    },
}
"""How every kernel is compiled: on its own, without an adjoint, free to fuse, to reorder and to use reciprocals (a
seventh of the time), but not to forget about NaN."""
