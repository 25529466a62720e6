"""
Damping over amplitude
======================

Test.
"""

import warpdamp

dataset = warpdamp.open_results("../docs/beam.nc")
warpdamp.draw(dataset)
