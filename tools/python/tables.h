#pragma once
/// Scenes as Python writes them: dicts of a scene file's keys, with arrays where the file names files.

#include "scenes/given_files.h"
#include "scenes/toml_table.h"

#include <pybind11/pybind11.h>

namespace haarfield::python {

namespace py = pybind11;

/// A mesh that was made of arrays.
struct ArrayMesh {
    std::shared_ptr<const GivenMesh> mesh;
};

/// Changes tables as a dict wants it: a dict in it changes the table of its name, everything else takes the
/// place of what was there, and None takes it away. Arrays under `image` and meshes under `mesh` are added to
/// what is given.
///
/// raises  TypeError for what no scene can hold, with its place: `materials.oak.diffuse`.
void change_tables(const py::dict& changes, toml::table& tables, GivenFiles& given);

/// The tables as a dict from which the same scene can be made: with a Mesh or an array for each name of
/// what is given.
py::dict dict_of(const toml::table& tables, const GivenFiles& given);

/// Adds Mesh to the module.
void add_mesh(py::module_& module);

}  // namespace haarfield::python
