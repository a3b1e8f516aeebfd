"""Blender's frame and haarfield's."""

import numpy

# Blender's z is up, haarfield's y: (x, y, z) is (x, z, -y) there.
TO_HAARFIELD = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
