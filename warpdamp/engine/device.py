"""Start Warp without its chatter.  Import before anything that touches a Warp array."""

from __future__ import annotations

import os
import sys
import tempfile

import warp as wp


def _start() -> None:
    """Initialise Warp; its native note that there is no CUDA driver is no news to a code that runs on the CPU.

    Whatever else the start prints to standard error is passed on.
    """
    wp.config.log_level = wp.LOG_WARNING
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


_start()
DEVICE = "cpu"
