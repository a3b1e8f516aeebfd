/// Bakes in Python: Scene.bake and Scene.budget.

#include "bridge/files/mesh_file.h"
#include "bridge/pictures/preview.h"
#include "bridge/povray/povray_process.h"
#include "fields/base/names.h"
#include "scenes/bake_search.h"
#include "scenes/original_vertices.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_budget.h"
#include "scenes/scene_shading.h"
#include "shading/scene/turned_light.h"
#include "tools/python/arrays.h"
#include "tools/python/images.h"
#include "tools/python/options.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>

namespace haarfield::python {

namespace {

constexpr auto baking = {OptionSet::vertices, OptionSet::occlusion, OptionSet::lighting, OptionSet::depth,
                         OptionSet::bake};
constexpr auto measuring = {OptionSet::occlusion, OptionSet::lighting, OptionSet::depth};

/// A bake, with everything that it refers to. Never changes.
struct Bake {
    std::shared_ptr<const PreparedScene> prepared;
    BakedScene baked;
    std::optional<OriginalBake> original;  ///< Present if original_vertices was requested.
    double seconds = 0;                    ///< Shading time.

    /// The instances for mesh files. POV-Ray files use those of `baked`.
    std::span<const BakedInstance> instances() const {
        return original ? original->instances : baked.instances;
    }
};

/// An instance of a bake.
struct BakedMesh {
    std::shared_ptr<const Bake> bake;
    std::size_t number;

    const BakedInstance& instance() const { return bake->instances()[number]; }
    const Mesh& mesh() const { return *instance().mesh; }

    template <class Element>
    py::array view(std::span<const Element> elements) const {
        return view_of<Element>(elements, bake);
    }
};

/// Prepares the vertices of a scene and shades them.
///
/// bake  receives the prepared scene and the time.
BakedScene shaded_bake(PythonScene& scene, const BakedVertices& vertices, RenderChoices choices,
                       const py::object& progress, Bake& bake) {
    bake.prepared = prepare(scene, progress, vertices);
    const PreparedScene& prepared = *bake.prepared;
    if (prepared.face_size != choices.shading.face_size)
        choices.shading.face_size = choices.bake.most_face_size = prepared.face_size;
    apply_bounces(prepared.scene, choices.shading.bounces);
    return long_call<BakedScene>(progress, [&](const Progress& watched) {
        const auto start = std::chrono::steady_clock::now();
        const ShadedScene shaded =
            shaded_scene(prepared.scene, *prepared.entities, prepared.light.environment);
        std::vector<std::optional<MeshPoint>> pixels;
        if (choices.bake.error && !choices.bake.everywhere)
            pixels = Preview().points(prepared.scene.camera, preview_instances(*prepared.entities, shaded));
        Result<BakedScene> baked = baked_scene(prepared.scene, *prepared.entities, shaded, choices.shading,
                                               choices.bake, watched, nullptr, pixels);
        bake.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return baked;
    });
}

std::shared_ptr<Bake> bake(PythonScene& scene, const py::object& progress, const py::kwargs& options) {
    RenderChoices choices = render_choices(options, baking, "Scene.bake");
    const bool original_vertices = choices.entities.original_vertices;
    choices.bake.error = target_error(choices);
    if (choices.bake.error && original_vertices)
        throw py::value_error(
            fmt::format("error is {}; expected 'off' with original_vertices", choices.error));
    if (choices.bake.error && choices.shading.occlusion == Occlusion::fields)
        throw py::value_error("occlusion is 'fields'; expected error='off' or another occlusion");
    if (choices.bake.refine && original_vertices)
        throw py::value_error(
            fmt::format("refine is {}; expected None with original_vertices", *choices.bake.refine));
    value_of(check_bake(choices.bake));
    const auto made = std::make_shared<Bake>();
    const BakeAttempt attempt = [&](std::optional<std::uint32_t> start,
                                    const BakeOptions& chosen) -> Result<BakedScene> {
        RenderChoices of_attempt = choices;
        of_attempt.bake = chosen;
        return shaded_bake(scene, {original_vertices, start}, std::move(of_attempt), progress, *made);
    };
    made->baked = value_of(repeated_bake(choices.bake, attempt));
    if (original_vertices) {
        made->original = original_bake(*made->prepared->entities, made->baked.instances, false);
        if (made->original->unvalued > 0)
            warn({fmt::format(
                "{} of the files' {} vertices belong to no triangle with an area and get radiance "
                "0",
                made->original->unvalued, made->original->vertices)});
    }
    return made;
}

std::size_t vertices_of(const Bake& bake) {
    std::size_t vertices = 0;
    for (const BakedInstance& instance : bake.instances()) vertices += instance.radiance.size();
    return vertices;
}

py::object error_of(const Bake& bake) {
    if (!bake.baked.search) return py::none();
    const SearchOutcome& search = *bake.baked.search;
    py::dict error;
    error["target"] = search.target;
    error["reached"] = search.error.total;
    error["low"] = search.error.low;
    error["high"] = search.error.high;
    error["between_vertices"] = search.error.between;
    error["at_vertices"] = search.error.at_vertices;
    error["indirect_light"] = search.error.indirect;
    error["is_met"] = search.end == SearchEnd::reached;
    error["reason"] = reason_of(search.end, search.vertex_budget);
    return error;
}

BakedMesh mesh_named(const std::shared_ptr<Bake>& bake, const std::string& name) {
    const std::span<const BakedInstance> instances = bake->instances();
    const auto found = std::ranges::find(instances, name, &BakedInstance::name);
    if (found == instances.end()) throw py::key_error("unknown instance \"" + name + "\"");
    return {bake, static_cast<std::size_t>(found - instances.begin())};
}

BakedMesh mesh_numbered(const std::shared_ptr<Bake>& bake, std::ptrdiff_t number) {
    const auto count = static_cast<std::ptrdiff_t>(bake->instances().size());
    if (number < -count || number >= count)
        throw py::index_error(fmt::format("instance {}; expected less than {}", number, count));
    return {bake, static_cast<std::size_t>(number < 0 ? number + count : number)};
}

py::dict write_povray(const Bake& bake, const std::filesystem::path& folder, const std::string& name) {
    const PreparedScene& prepared = *bake.prepared;
    const std::string stem = plain_name(name.empty() ? prepared.scene.name : name);
    const auto files = long_call<BakedFiles>(py::none(), [&](const Progress&) {
        const LatLongImage background = image_with_suns(prepared.light.environment);
        return write_baked_scene(folder, stem, prepared.scene.camera, bake.baked.instances,
                                 BackgroundDescription{&background, false, prepared.scene.assumed_gamma});
    });
    if (files.clamped_vertices > 0)
        warn({fmt::format("{}: the radiance of {} vertices is clamped to [0, 65000]", stem,
                          files.clamped_vertices)});
    py::dict written;
    written["scene"] = files.scene;
    written["includes"] = files.includes;
    written["objects"] = files.objects;
    written["images"] = files.images;
    return written;
}

Result<Done> write_mesh(const Bake& bake, const MeshFormat& format, const std::filesystem::path& file) {
    if (!bake.original || !format.has_images) return format.write(file, bake.instances());
    return format.write(
        file, original_bake(*bake.prepared->entities, bake.baked.instances, /*with_images=*/true).textured);
}

/// Renders the picture like POV-Ray, without POV-Ray.
py::array picture_of(const Bake& bake) {
    const PreparedScene& prepared = *bake.prepared;
    const auto image = std::make_shared<const Image>(long_call<Image>(py::none(), [&](const Progress&) {
        const LatLongImage background = image_with_suns(prepared.light.environment);
        return Result<Image>(Preview().draw(
            prepared.scene.camera, bake.baked.instances,
            [&](const Vec3f& direction) { return radiance_from(background, Vec3d(direction)); }));
    }));
    return pixels_of(image);
}

py::tuple rendered(const Bake& bake, const std::filesystem::path& folder, int antialiasing,
                   const py::object& progress) {
    if (!(antialiasing >= 0 && antialiasing <= 9))
        throw py::value_error(fmt::format("antialiasing is {}; expected 0 to 9", antialiasing));
    const auto scene = write_povray(bake, folder, "")["scene"].cast<std::filesystem::path>();
    const PovrayOptions options = picture_options(bake.prepared->scene.camera, antialiasing);
    auto picture = long_call<RenderedScene>(progress, [&](const Progress& watched) {
        return render_scene(scene, folder / "baked.exr", options, watched);
    });
    const auto image = std::make_shared<const Image>(std::move(picture.image));
    return py::make_tuple(pixels_of(image), coverage_of(image));
}

/// Returns the displayed radiance of each vertex; a view if there are no textures.
py::array seen(const BakedMesh& self) {
    const BakedInstance& instance = self.instance();
    if (instance.surfaces.empty()) return self.view(instance.radiance);
    std::vector<Rgb> radiance(instance.radiance.size());
    for (std::size_t v = 0; v < radiance.size(); ++v) radiance[v] = displayed_radiance(instance, v);
    return array_of(std::move(radiance));
}

py::dict passes_of(const BakedMesh& self) {
    py::dict passes;
    for (const VertexValues& pass : self.instance().passes)
        passes[py::str(pass.name)] =
            pass.is_scalar ? py::object(self.view(pass.values)[py::make_tuple(py::ellipsis(), 0)])
                           : py::object(self.view(pass.values));
    return passes;
}

py::list budget(PythonScene& scene, std::size_t points, const py::object& progress,
                const py::kwargs& options) {
    if (!(points >= 1 && points <= 1'000'000))
        throw py::value_error(fmt::format("points is {}; expected [1, 1e6]", points));
    RenderSettings settings = render_choices(options, measuring, "Scene.budget").shading;
    const auto prepared = prepare(scene, progress);
    settings.face_size = prepared->face_size;
    apply_bounces(prepared->scene, settings.bounces);
    const auto made = long_call<SceneBudget>(progress, [&](const Progress& watched) {
        const ShadedScene shaded =
            shaded_scene(prepared->scene, *prepared->entities, prepared->light.environment);
        return scene_budget(*prepared->entities, shaded, settings, points,
                            Preview().points(prepared->scene.camera, preview_instances(shaded)), watched);
    });
    py::list entries;
    for (const BudgetEntry& entry : made.entries) {
        py::dict added;
        added["approximation"] = entry.name;
        added["meaning"] = entry.meaning;
        added["relative_rmse"] = entry.relative_rmse;
        added["relative_99"] = entry.relative_99;
        added["bias"] = entry.bias;
        added["points"] = entry.points;
        entries.append(added);
    }
    return entries;
}

void add_baked_mesh(py::module_& module) {
    py::class_<BakedMesh> mesh(
        module, "BakedMesh",
        "An instance of a bake: its mesh, its placement and the radiance of its vertices.\n\n"
        "Arrays are read-only views of the bake's memory, without copies.");
    mesh.def_property_readonly(
        "name", [](const BakedMesh& self) { return self.instance().name; }, "The instance's name.");
    mesh.def_property_readonly(
        "positions", [](const BakedMesh& self) { return self.view<Vec3f>(self.mesh().positions); },
        "(N, 3) in the object's frame, metres: world = matrix @ (x, y, z, 1).");
    mesh.def_property_readonly(
        "normals", [](const BakedMesh& self) { return self.view<Vec3f>(self.mesh().normals); },
        "(N, 3) in the object's frame, unit length.");
    mesh.def_property_readonly(
        "triangles",
        [](const BakedMesh& self) { return self.view<std::array<std::uint32_t, 3>>(self.mesh().triangles); },
        "(M, 3), counter-clockwise seen from outside. With original_vertices: the file's faces, "
        "triangulated.");
    mesh.def_property_readonly(
        "original_vertices",
        [](const BakedMesh& self) -> py::object {
            if (self.mesh().original_vertices.empty()) return py::none();
            return self.view<std::int32_t>(self.mesh().original_vertices);
        },
        "(N,): the vertex number in the model file, or -1 for added vertices. None if unknown.");
    mesh.def_property_readonly(
        "uvs",
        [](const BakedMesh& self) -> py::object {
            if (self.mesh().uvs.empty()) return py::none();
            return self.view<Vec2f>(self.mesh().uvs);
        },
        "(N, 2), or None if no image is used.");
    mesh.def_property_readonly(
        "materials", [](const BakedMesh& self) { return self.mesh().material_names; },
        "The names of the mesh's materials.");
    mesh.def_property_readonly(
        "vertex_materials",
        [](const BakedMesh& self) { return self.view<std::uint16_t>(self.mesh().vertex_materials); },
        "(N,) indices of materials.");
    mesh.def_property_readonly(
        "matrix", [](const BakedMesh& self) { return matrix_of(self.instance().placement); },
        "(4, 4), from the object's frame to the world; multiplies column vectors.");
    mesh.def_property_readonly(
        "radiance", &seen,
        "(N, 3), outgoing and linear, W/(m^2 sr), as `haarfield bake` writes it into PLY files.");
    mesh.def_property_readonly(
        "under", [](const BakedMesh& self) { return self.view(self.instance().radiance); },
        "(N, 3): the light that the materials' images multiply. Without images, the radiance itself.");
    mesh.def_property_readonly(
        "over",
        [](const BakedMesh& self) -> py::object {
            if (self.instance().added.empty()) return py::none();
            return self.view(self.instance().added);
        },
        "(N, 3): specular radiance that is added to textured light; None if there is none.");
    mesh.def_property_readonly(
        "passes", &passes_of,
        "The requested passes by name, with _ instead of -: (N, 3), or (N,) for occlusion.");
    mesh.def("__len__", [](const BakedMesh& self) { return self.mesh().positions.size(); });
    mesh.def("__repr__", [](const BakedMesh& self) {
        return fmt::format("<haarfield.BakedMesh \"{}\" of {} vertices>", self.instance().name,
                           self.mesh().positions.size());
    });
}

}  // namespace

void add_bake(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene) {
    add_baked_mesh(module);
    py::class_<Bake, std::shared_ptr<Bake>> made(
        module, "Bake", "A shaded scene. bake[\"chair_1\"] and bake[0] are instances.");
    made.def("__len__", [](const Bake& self) { return self.baked.instances.size(); });
    made.def("__getitem__", &mesh_named, py::arg("name"));
    made.def("__getitem__", &mesh_numbered, py::arg("number"));
    made.def("__contains__", [](const Bake& self, const py::object& name) {
        return py::isinstance<py::str>(name) &&
               std::ranges::find(self.instances(), name.cast<std::string>(), &BakedInstance::name) !=
                   self.instances().end();
    });
    made.def(
        "keys",
        [](const Bake& self) {
            std::vector<std::string> names;
            for (const BakedInstance& instance : self.instances()) names.push_back(instance.name);
            return names;
        },
        "The names of the instances, in order. dict(bake) has all instances.");
    made.def("__repr__", [](const Bake& self) {
        return fmt::format("<haarfield.Bake of {} vertices in {} instances>", vertices_of(self),
                           self.baked.instances.size());
    });
    made.def_property_readonly("vertices", &vertices_of, "The number of vertices of all instances.");
    made.def_property_readonly(
        "error", &error_of,
        "The error that the bake reached, as a dict: target, reached, low and high (the "
        "90 % interval), between_vertices, at_vertices, indirect_light, is_met, reason. "
        "None with error='off'.");
    made.def_property_readonly(
        "seconds", [](const Bake& self) { return self.seconds; }, "The shading time.");
    made.def("write_povray", &write_povray, py::arg("folder"), py::arg("name") = "",
             R"(Writes NAME.pov and one include for each instance.

name     the scene's, if empty.
returns  a dict: scene, includes, objects (what each include declares), images.)");
    for (const MeshFormat& format : mesh_formats())
        made.def(
            fmt::format("write_{}", format.name).c_str(),
            [format](const Bake& self, const std::filesystem::path& file) {
                long_call<Done>(py::none(), [&](const Progress&) { return write_mesh(self, format, file); });
            },
            py::arg("path"), fmt::format("Writes {}.", format.summary).c_str());
    made.def(
        "render", &rendered, py::arg("folder"), py::arg("antialiasing") = 3, py::arg("progress") = py::none(),
        "Writes the POV-Ray scene and renders it: baked.exr and baked.png in the folder.\n\n"
        "returns  the objects' radiance (height, width, 3) and coverage (height, width), like read_image.");
    made.def("picture", &picture_of,
             "(height, width, 3): a quick picture with its background, drawn without POV-Ray.");
    py::options undocumented;
    undocumented.disable_function_signatures();
    scene.def(
        "bake", &bake, py::arg("progress") = py::none(),
        option_docstring("bake", "", baking, "haarfield._haarfield.Bake",
                         "Shades every vertex. Bit-identical to `haarfield bake`, whose options have the "
                         "same names.")
            .c_str());
    scene.def("budget", &budget, py::arg("points") = 400, py::arg("progress") = py::none(),
              option_docstring("budget", "points: int = 400", measuring, "list",
                               "Measures the error of each approximation of a bake against dense sums.\n\n"
                               "returns  a list of dicts, as `haarfield budget --report`: approximation, "
                               "meaning, relative_rmse,\n         relative_99, bias, points.")
                  .c_str());
}

}  // namespace haarfield::python
