/// The Python module: `import haarfield` imports this one, haarfield._haarfield.

#include "fields/file/reader_process.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

namespace haarfield::python {

namespace {

/// Sets how many threads all calls use; 0: one for each core.
void use_threads(int count) {
    if (count < 0 || count > 1024) throw py::value_error(fmt::format("count is {}; wanted 0 to 1024", count));
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
        "A scene: meshes, materials, where things stand, the camera and distant light. haarfield.open and\n"
        "haarfield.scene make them; they never change, and may be used by several threads.");
    add_mathematics(module);
    add_scene(module, scene);
    add_field(module, scene);
    add_bake(module, scene);
    add_reference(module, scene);
    add_session(module, scene);
    add_images(module);
    module.def(
        "allow_unsandboxed_readers", &allow_unsandboxed_readers,
        "Lets haarfield read meshes and images without a sandbox where no sandbox can be set up. Without\n"
        "this call such files are refused. A malicious file can then do what this process can.");
    module.def(
        "use_threads", &use_threads, py::arg("count"),
        "How many threads haarfield uses from now on; 0: one for each core. Results do not depend on it.");
}

}  // namespace haarfield::python
