#pragma once
/// Scenes in Python: opened from files or made from dicts and arrays, prepared once, shared by bakes and
/// sessions.

#include "scenes/scene_entities.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_tables.h"
#include "tools/python/long_call.h"
#include "tools/python/tables.h"

#include <pybind11/numpy.h>
#include <optional>

#include <atomic>
#include <map>

namespace haarfield::python {

/// A scene with all data for shading. Immutable.
struct PreparedScene {
    Scene scene;  ///< Its camera is known.
    std::shared_ptr<const SceneEntities> entities;
    SceneEnvironment light;
    std::vector<std::string> warnings;
    int face_size = 64;
    mutable std::atomic<bool> is_told = false;  ///< True if the warnings have been issued.
};

/// The vertices of a prepared scene; those of the fine meshes by default. At most one member is set.
struct BakedVertices {
    bool original = false;                        ///< Those of SceneEntityOptions::original_vertices.
    std::optional<std::uint32_t> search_start{};  ///< Those of search_start.

    auto operator<=>(const BakedVertices&) const = default;
};

/// A scene with cached results of its preparation. Thread-safe.
class PythonScene {
public:
    PythonScene(toml::table tables, TablesOrigin origin, Scene scene)
        : tables_(std::move(tables)), origin_(std::move(origin)), scene_(std::move(scene)) {}

    const Scene& scene() const { return scene_; }
    const toml::table& tables() const { return tables_; }
    const FilesInMemory& given() const { return *origin_.given; }

    /// Sets the options of fields, and discards cached preparations.
    void set_options(const SceneEntityOptions& options);

    /// Returns the prepared scene; prepares it if necessary.
    Result<std::shared_ptr<const PreparedScene>> prepared(const BakedVertices& vertices,
                                                          const Progress& progress);

    /// Returns another scene with changes. Shares prepared data if entities, materials and instances are
    /// unchanged.
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
    mutable std::timed_mutex mutex_;  ///< Guards the members below, and options_.
    std::map<BakedVertices, Made> made_;
};

/// Returns the prepared scene. Issues its warnings; can be interrupted by Ctrl-C.
std::shared_ptr<const PreparedScene> prepare(PythonScene& scene, const py::object& progress,
                                             const BakedVertices& vertices = {});

/// Returns a placement as a matrix of four rows, which multiplies column vectors.
py::array matrix_of(const Placement& placement);

/// Adds open, scene and Scene to the module. Separate files add the methods for pictures and light.
void add_scene(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);

/// Each function adds methods to Scene, and the classes that they return.
void add_bake(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_reference(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_session(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);
void add_field(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene);

/// Functions that need no scene.
void add_images(py::module_& module);
void add_mathematics(py::module_& module);

}  // namespace haarfield::python
