"""Options that kernels are compiled with."""

import platform

import warp as wp

LANES = 8
"""Contacts that are computed side by side; see ``lanes.py``."""

VECTORS = f"-mllvm -force-vector-width={LANES}"
if platform.machine().lower() in ("x86_64", "amd64"):
    VECTORS += " -mprefer-vector-width=512 -target-feature +prefer-no-gather"
"""Vectors as wide as the lanes, whatever the compiler thinks they cost; and loads one by one instead of the slow
instruction that gathers."""

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
