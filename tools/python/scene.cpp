#include "tools/python/scene.h"

#include "scenes/bake_search.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_tables.h"
#include "tools/python/arrays.h"
#include "tools/python/options.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace haarfield::python {

namespace {

std::shared_ptr<PythonScene> made_scene(toml::table tables, TablesOrigin origin) {
    Scene scene = value_of(scene_of_tables(tables, origin));
    return std::make_shared<PythonScene>(std::move(tables), std::move(origin), std::move(scene));
}

std::shared_ptr<PythonScene> opened(const std::filesystem::path& file, const py::object& changes) {
    toml::table tables = value_of(read_toml(file));
    const auto given = std::make_shared<FilesInMemory>();
    if (!changes.is_none()) change_tables(changes.cast<py::dict>(), tables, *given);
    return made_scene(std::move(tables), {file.string(), file.stem().string(), file.parent_path(), given});
}

std::shared_ptr<PythonScene> described(const py::dict& description, const std::string& name,
                                       const std::filesystem::path& folder) {
    toml::table tables;
    const auto given = std::make_shared<FilesInMemory>();
    change_tables(description, tables, *given);
    return made_scene(std::move(tables), {name, name, folder, given});
}

py::dict camera_of(const Camera& camera) {
    py::dict result;
    result["position"] = py::make_tuple(camera.position.x, camera.position.y, camera.position.z);
    result["target"] = py::make_tuple(camera.target.x, camera.target.y, camera.target.z);
    result["vertical_fov"] = double(camera.vertical_fov) * (180 / pi);
    result["resolution"] = py::make_tuple(camera.width, camera.height);
    return result;
}

void choose_fields(PythonScene& scene, const std::optional<std::filesystem::path>& fields,
                   const py::object& progress, const py::kwargs& options) {
    SceneEntityOptions chosen = render_choices(options, {OptionSet::fields}, "Scene.prepare").entities;
    if (fields) chosen.fields_folder = *fields;
    scene.set_options(chosen);
    prepare(scene, progress);
}

}  // namespace

void PythonScene::set_options(const SceneEntityOptions& options) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    options_ = options;
    made_ = {};
}

Result<std::shared_ptr<const PreparedScene>> PythonScene::prepared(const BakedVertices& vertices,
                                                                   const Progress& progress) {
    const Turn turn(mutex_, progress);
    if (!turn) return interruption();
    auto& [shared_entities, shared] = made_[vertices];
    if (shared) return shared;
    const auto made = std::make_shared<PreparedScene>();
    made->scene = scene_;
    made->face_size = options_.face_size;
    HF_TRY(SceneEnvironment light, scene_environment(scene_));
    made->light = std::move(light);
    made->warnings = made->light.warnings;
    if (!shared_entities) {
        SceneEntityOptions options = options_;
        options.original_vertices = vertices.original;
        const std::optional<std::uint32_t> start = vertices.search_start;
        if (start) options.fields = search_fields(scene_, Occlusion::automatic);
        HF_TRY(SceneEntities entities,
               prepare_scene_entities(start ? search_start(scene_, *start) : scene_, options, progress));
        made->warnings.insert(made->warnings.end(), entities.warnings.begin(), entities.warnings.end());
        shared_entities = std::make_shared<const SceneEntities>(std::move(entities));
    }
    made->entities = shared_entities;
    made->scene.camera = scene_camera(scene_, *made->entities);
    made->scene.finds_camera = false;
    if (const float stops = entity_stops(made->scene, *made->entities, made->light.environment); stops != 0) {
        made->light.environment = turned_environment(std::move(made->light.environment), 0, double(stops));
        made->light.exposure += stops;
    }
    for (std::string& trouble : camera_troubles(made->scene, *made->entities))
        made->warnings.push_back(std::move(trouble));
    shared = made;
    return shared;
}

std::shared_ptr<PythonScene> PythonScene::changed(const py::dict& changes) const {
    toml::table tables = tables_;
    const auto given = std::make_shared<FilesInMemory>(*origin_.given);
    change_tables(changes, tables, *given);
    TablesOrigin origin = origin_;
    origin.given = given;
    const auto result = made_scene(std::move(tables), std::move(origin));
    const auto same = [&](const char* key) {
        const toml::node *before = tables_.get(key), *after = result->tables_.get(key);
        if (before == nullptr || after == nullptr) return before == after;
        if (before->is_table() && after->is_table()) return *before->as_table() == *after->as_table();
        return before->is_array() && after->is_array() && *before->as_array() == *after->as_array();
    };
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    result->options_ = options_;
    if (same("entities") && same("materials") && same("instances"))
        for (const auto& [vertices, made] : made_) result->made_[vertices].entities = made.entities;
    return result;
}

std::shared_ptr<const PreparedScene> prepare(PythonScene& scene, const py::object& progress,
                                             const BakedVertices& vertices) {
    const auto prepared = long_call<std::shared_ptr<const PreparedScene>>(
        progress, [&](const Progress& watched) { return scene.prepared(vertices, watched); });
    if (!prepared->is_told.exchange(true)) warn(prepared->warnings);
    return prepared;
}

py::array matrix_of(const Placement& placement) {
    const std::array<float, 12> columns = placement.columns();
    std::vector<double> rows(16, 0);
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            rows[4 * row + column] = double(columns[3 * column + row]);
    rows[15] = 1;
    return array_of(std::move(rows), {4, 4});
}

void add_scene(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene) {
    module.def("open", &opened, py::arg("path"), py::arg("changes") = py::none(),
               R"(Opens a scene file.

path     the TOML file; scenes/SCENE_FILE.md describes its keys.
changes  a dict of these keys that overrides the file: {"environment": {"rotation": 90}}. None removes a key. Meshes
         may be haarfield.Mesh, and images may be arrays, as in haarfield.scene.

raises   haarfield.Error, with line and column of an error in the file.)");
    module.def("scene", &described, py::arg("description"), py::arg("name") = "scene",
               py::arg("folder") = ".",
               R"(Makes a scene from the keys of a scene file.

description  a dict with the structure of the file's tables. A haarfield.Mesh can replace the name of a mesh file. An
             array can replace the name of an image: (height, 2 height, 3) of linear radiance for the environment,
             (height, width, 3 or 4) for a material, with sRGB bytes or linear floats.
name         the stem of POV-Ray files.
folder       the base of relative file names.

raises       haarfield.Error, with the messages of the scene reader; TypeError and ValueError for unsuitable
             arrays.)");
    scene.def("__repr__", [](const PythonScene& self) {
        return fmt::format("<haarfield.Scene \"{}\" of {} instances>", self.scene().name,
                           self.scene().instances.size());
    });
    scene.def_property_readonly(
        "name", [](const PythonScene& self) { return self.scene().name; },
        "The file's name without its extension.");
    scene.def_property_readonly(
        "instances",
        [](const PythonScene& self) {
            std::vector<std::string> names;
            for (const Instance& instance : self.scene().instances) names.push_back(instance.name);
            return names;
        },
        "The names of the instances, in the order of all lists of instances.");
    scene.def_property_readonly(
        "description", [](const PythonScene& self) { return dict_of(self.tables(), self.given()); },
        "A copy of the tables from which the scene was made; haarfield.scene(description) makes the same\n"
        "scene. Meshes of arrays are haarfield.Mesh objects, images are arrays of linear floats.");
    scene.def(
        "camera", [](PythonScene& self) { return camera_of(prepare(self, py::none())->scene.camera); },
        "The camera with the keys of a scene file, found automatically if the scene has none: a dict of\n"
        "position and target [m], vertical_fov [degrees], resolution [pixels].");
    scene.def(
        "environment",
        [](PythonScene& self) {
            const auto prepared = prepare(self, py::none());
            const LatLongImage& image = prepared->light.environment.image;
            return view_of<Rgb>(image.pixels, prepared, {image.height, image.width});
        },
        "The distant light: (height, width, 3) radiance, cleaned, rotated and exposed; of an analytic sky "
        "without "
        "the\nsun's disc.");
    scene.def(
        "changed", &PythonScene::changed, py::arg("changes"),
        "Another scene, with changes as haarfield.open takes them. It shares meshes and fields with this one "
        "if\nneither entities, materials nor instances change.");
    py::options undocumented;
    undocumented.disable_function_signatures();
    scene.def(
        "prepare", &choose_fields, py::arg("fields") = py::none(), py::arg("progress") = py::none(),
        option_docstring("prepare", "fields: os.PathLike | None = None", {OptionSet::fields}, "None",
                         "Prepares the meshes and computes the visibility fields. Bakes and sessions do "
                         "so if it was not done.\n\n"
                         "fields             Folder that stores them as files, for reuse; None: no files.")
            .c_str());
}

}  // namespace haarfield::python
