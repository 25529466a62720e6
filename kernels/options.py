"""Options that kernels are compiled with."""

import warp as wp

UNIQUE = {
    "module": "unique",
    "enable_backward": False,
    "module_options": {
        "cpu_compiler_flags": f"{wp.config.cpu_compiler_flags} "
        "-ffp-contract=fast -freciprocal-math -fno-signed-zeros -mreassociate"
    },
}
"""How every kernel is compiled: on its own, without an adjoint, free to fuse, to reorder and to use reciprocals (a
seventh of the time), but not to forget about NaN."""
