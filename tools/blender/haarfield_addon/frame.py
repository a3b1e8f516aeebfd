"""Conversion between Blender's frame and haarfield's."""

import numpy

# Blender's z points up, haarfield's y: Blender's (x, y, z) is haarfield's (x, z, -y).
TO_HAARFIELD = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
