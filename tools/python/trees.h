#pragma once
/// Converts quadtrees of Haar wavelets to arrays.

#include "fields/wavelets/haar_transform.h"

#include <pybind11/numpy.h>

namespace haarfield::python {

namespace py = pybind11;

/// A function of direction in Python: its trees, and their number of texels along an edge.
struct PythonTree {
    CubemapTree trees;
    int size = 64;
};

/// Returns a face's tree as a dict of scaling, wavelets (n, 3) and children (n, 4), -1 for no child.
py::dict arrays_of(const Quadtree& tree);

/// Returns the texels: (6, N, N).
py::array texels_of(const CubemapTree& tree, int size);

}  // namespace haarfield::python
