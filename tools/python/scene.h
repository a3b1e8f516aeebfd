#pragma once
/// Scenes in Python: opened or made of dicts and arrays, prepared once, shared by bakes and sessions.

#include "scenes/scene_entities.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_tables.h"
#include "tools/python/long_call.h"
#include "tools/python/tables.h"

#include <pybind11/numpy.h>
#include <optional>

#include <atomic>

namespace haarfield::python {

/// A scene with everything that shading needs. Never changes.
struct PreparedScene {
    Scene scene;  ///< Its camera has a place.
    std::shared_ptr<const SceneEntities> entities;
    SceneEnvironment light;
    std::vector<std::string> warnings;
    int face_size = 64;
    mutable std::atomic<bool> is_told = false;  ///< Whether the warnings have been told.
};

/// Which vertices a scene is prepared with: its fine meshes', or SceneEntityOptions::original_vertices.
enum class BakedVertices { fine, original };

/// A scene, and what was made of it so far. Safe to use from several threads.
class PythonScene {
public:
    PythonScene(toml::table tables, TablesOrigin origin, Scene scene)
        : tables_(std::move(tables)), origin_(std::move(origin)), scene_(std::move(scene)) {}

    const Scene& scene() const { return scene_; }
    const toml::table& tables() const { return tables_; }
    const GivenFiles& given() const { return *origin_.given; }

    /// Chooses how fields are made and where they are kept; what was prepared is void.
    void set_options(const SceneEntityOptions& options);

    /// Prepared, now if it has not been.
    Result<std::shared_ptr<const PreparedScene>> prepared(BakedVertices vertices, const Progress& progress);

    /// Another one, with changes. It shares what was prepared if entities, materials and instances are the
    /// same.
    std::shared_ptr<PythonScene> changed(const py::dict& changes) const;

private:
    struct Made {
        std::shared_ptr<const SceneEntities> entities;
        std::shared_ptr<const PreparedScene> prepared;
    };

    toml::table tables_;
    TablesOrigin origin_;
    Scene scene_;
    SceneEntityOptions options_;
    mutable std::timed_mutex mutex_;  ///< Of what follows, and of options_.
    std::array<Made, 2> made_;        ///< By BakedVertices.
};

/// Prepared, with warnings told and Ctrl-C heard.
std::shared_ptr<const PreparedScene> prepare(PythonScene& scene, const py::object& progress,
                                             BakedVertices vertices = BakedVertices::fine);

/// A placement as a matrix of four rows that stands before columns.
py::array matrix_of(const Placement& placement);

/// Adds open, scene and Scene to the module; what Scene does with pictures and light is in files of its own.
void add_scene(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);

/// Each adds methods to Scene, with the classes that they return.
void add_bake(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_reference(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_session(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_field(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);

/// And those that need no scene.
void add_images(py::module_& module);
void add_mathematics(py::module_& module);

}  // namespace haarfield::python
