/// Ray-traced references in Python: Scene.reference.

#include "bridge/povray/reference_lights.h"
#include "fields/base/names.h"
#include "tools/python/arrays.h"
#include "tools/python/images.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace haarfield::python {

namespace {

/// A reference, rendered or only written.
struct Reference {
    std::shared_ptr<const Image> image;  ///< Null: not rendered.
    ReferenceFiles files;
};

Result<Reference> made_reference(const PreparedScene& prepared, const std::filesystem::path& folder,
                                 int lights, const std::optional<double>& relative_error, int antialiasing,
                                 bool render, int bounces, const Progress& progress) {
    HF_TRY(const SceneEntities originals, original_entities(prepared.scene, progress));
    const std::vector<ReferenceInstance> instances = reference_instances(prepared.scene, originals);
    const std::string stem = plain_name(prepared.scene.name) + "_reference";
    const Camera& camera = prepared.scene.camera;
    const Environment& environment = prepared.light.environment;
    const std::vector<Lamp> lamps = lamps_of(prepared.scene.lamps);
    const PovrayOptions povray = picture_options(camera, antialiasing);
    std::vector<std::string> warnings;
    if (relative_error) {
        HF_TRY(const LightEstimate estimate, lights_for_error(folder, stem, camera, instances, environment,
                                                              lamps, povray, *relative_error, progress));
        lights = estimate.lights;
        if (estimate.relative_error > *relative_error)
            warnings.push_back(
                fmt::format("a relative error of {} needs more than {} lights", *relative_error, lights));
    }
    HF_TRY(ReferenceFiles files,
           write_reference_scene(folder, stem, camera, instances, environment, lights, {bounces}, lamps,
                                 prepared.scene.filters, prepared.scene.assumed_gamma));
    files.warnings.insert(files.warnings.begin(), warnings.begin(), warnings.end());
    Reference reference{nullptr, std::move(files)};
    if (!render) return reference;
    HF_TRY(ReferencePicture picture, rendered_reference(reference.files, povray, progress));
    HF_TRY_DONE(write_with_background(picture.image, reference.files.scene, folder / "reference.exr", povray,
                                      progress));
    if (std::string warning = reference_warning(double(*picture.image.relative_error)); !warning.empty())
        reference.files.warnings.push_back(std::move(warning));
    reference.image = std::make_shared<const Image>(std::move(picture.image));
    return reference;
}

py::dict reference(PythonScene& scene, const std::filesystem::path& folder, int lights,
                   const std::optional<double>& relative_error, int antialiasing, bool render, int bounces,
                   const py::object& progress) {
    if (!(lights >= 16 && lights <= 100'000))
        throw py::value_error(fmt::format("lights is {}; expected [16, 100000]", lights));
    if (relative_error && !(*relative_error >= 1e-4 && *relative_error <= 1))
        throw py::value_error(
            fmt::format("relative_error is {}; expected [0.0001, 1], or None", *relative_error));
    if (!(antialiasing >= 0 && antialiasing <= 9))
        throw py::value_error(fmt::format("antialiasing is {}; expected 0 to 9", antialiasing));
    if (!(bounces >= 0 && bounces <= 20))
        throw py::value_error(fmt::format("bounces is {}; expected 0 to 20", bounces));
    const auto prepared = prepare(scene, progress);
    const auto made = long_call<Reference>(progress, [&](const Progress& watched) {
        return made_reference(*prepared, folder, lights, relative_error, antialiasing, render, bounces,
                              watched);
    });
    warn(made.files.warnings);
    py::dict result;
    result["scene"] = made.files.scene;
    result["includes"] = made.files.includes;
    result["lights"] = made.files.lights;
    if (!made.image) return result;
    result["image"] = pixels_of(made.image);
    result["coverage"] = coverage_of(made.image);
    result["relative_error"] = *made.image->relative_error;
    return result;
}

}  // namespace

void add_reference(py::module_&, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene) {
    scene.def(
        "reference", &reference, py::arg("folder"), py::arg("lights") = 1024,
        py::arg("relative_error") = py::none(), py::arg("antialiasing") = 3, py::arg("render") = true,
        py::arg("bounces") = 0, py::arg("progress") = py::none(),
        R"(Renders the scene with POV-Ray's own ray tracer, like `haarfield reference`: the original meshes under a dome
of distant lights. Writes NAME_reference.pov, reference.exr and reference.png.

lights          maximum number of lights that represent the environment.
relative_error  use as many lights as this relative error of the reference requires.
render          False: write the scene only.
bounces         number of bounces of indirect light between diffuse surfaces, by POV-Ray's radiosity. Takes minutes and
                adds noise that relative_error does not include. 0: direct light alone, like bake(bounces=0).

returns         a dict: image (height, width, 3), coverage (height, width), relative_error of the reference itself,
                lights, and the files: scene, includes.)");
}

}  // namespace haarfield::python
