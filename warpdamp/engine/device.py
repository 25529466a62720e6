"""Start of Warp without its messages.  Import before anything that touches a Warp array."""

from __future__ import annotations

import os
import sys
import tempfile

import warp as wp

from ..errors import PackingError
from ..files import cache_folder


def _start() -> None:
    """Initialise Warp; its native note that there is no CUDA driver is no news to a code that runs on the CPU.

    Whatever else the start prints to standard error is passed on.
    """
    wp.config.log_level = wp.LOG_WARNING
    if "WARP_CACHE_PATH" not in os.environ:  # Warp's own variable, for its kernels alone
        wp.config.kernel_cache_dir = str(cache_folder("kernels"))
    sys.stderr.flush()
    with tempfile.TemporaryFile() as caught:
        kept = os.dup(2)
        os.dup2(caught.fileno(), 2)
        try:
            wp.init()
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        caught.seek(0)
        for line in caught.read().decode(errors="replace").splitlines():
            if "CUDA driver" not in line:
                print(line, file=sys.stderr)


def check_device(device: str) -> None:
    """Refuse a device that this machine lacks.

    Raises
    ------
    PackingError
        With the devices that there are.
    """
    if device not in present():
        raise PackingError(f"there is no {device} device here: take {' or '.join(present())}", "numerics.device")


def present() -> list[str]:
    """Kinds of devices of this machine, as "cpu" and "cuda"."""
    return ["cpu", "cuda"][: 1 + wp.is_cuda_available()]


_start()
