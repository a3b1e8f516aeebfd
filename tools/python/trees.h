#pragma once
/// Quadtrees of Haar wavelets as arrays.

#include "fields/wavelets/haar_transform.h"

#include <pybind11/numpy.h>

namespace haarfield::python {

namespace py = pybind11;

/// A function of direction in Python: its trees, and how many texels along an edge they are meant for.
struct PythonTree {
    CubemapTree trees;
    int size = 64;
};

/// A face's tree: a dict of scaling, wavelets (n, 3) and children (n, 4), -1 where there is none.
py::dict arrays_of(const Quadtree& tree);

/// (6, N, N)
py::array texels_of(const CubemapTree& tree, int size);

}  // namespace haarfield::python
