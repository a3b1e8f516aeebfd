#pragma once
/// Scenes in Python: dicts with the keys of a scene file, and arrays in place of file names.

#include "scenes/files_in_memory.h"
#include "scenes/toml_table.h"

#include <pybind11/pybind11.h>

namespace haarfield::python {

namespace py = pybind11;

/// A mesh made of arrays.
struct ArrayMesh {
    std::shared_ptr<const MeshInMemory> mesh;
};

/// Changes tables according to a dict. A dict inside changes the table of its name, other values replace the
/// existing ones, and None removes them. Arrays under `image` and meshes under `mesh` are added to the given
/// files.
///
/// raises  TypeError for values that no scene can contain, with their place: `materials.oak.diffuse`.
void change_tables(const py::dict& changes, toml::table& tables, FilesInMemory& given);

/// Returns the tables as a dict from which the same scene can be made, with a Mesh or an array in place of
/// the name of each given file.
py::dict dict_of(const toml::table& tables, const FilesInMemory& given);

/// Adds Mesh to the module.
void add_mesh(py::module_& module);

}  // namespace haarfield::python
