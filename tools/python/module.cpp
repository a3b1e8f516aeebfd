/// The Python module: `import haarfield` imports this module, haarfield._haarfield.

#include "fields/file/reader_process.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

namespace haarfield::python {

namespace {

/// Sets the number of threads of all calls; 0: one per core.
void use_threads(int count) {
    if (count < 0 || count > 1024)
        throw py::value_error(fmt::format("count is {}; expected 0 to 1024", count));
    static std::unique_ptr<tbb::global_control> limit;
    limit.reset();
    if (count == 0) return;
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(count));
}

}  // namespace

PYBIND11_MODULE(_haarfield, module) {
    module.attr("__version__") = HAARFIELD_VERSION;
    add_errors(module);
    add_mesh(module);
    py::class_<PythonScene, std::shared_ptr<PythonScene>> scene(
        module, "Scene",
        "A scene: meshes, materials, placements, the camera and light. haarfield.open and haarfield.scene\n"
        "make scenes. Scenes are immutable and thread-safe.");
    add_mathematics(module);
    add_scene(module, scene);
    add_field(module, scene);
    add_bake(module, scene);
    add_reference(module, scene);
    add_session(module, scene);
    add_images(module);
    module.def("allow_unsandboxed_readers", &allow_unsandboxed_readers,
               "Lets haarfield read meshes and images without a sandbox if no sandbox can be set up.\n"
               "Otherwise such files are rejected. Without a sandbox, a malicious file can do what this\n"
               "process can.");
    module.def(
        "use_threads", &use_threads, py::arg("count"),
        "Sets the number of threads that haarfield uses; 0: one per core. Results do not depend on it.");
}

}  // namespace haarfield::python
