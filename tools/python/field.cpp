/// Visibility fields in Python: read_field and Scene.field.

#include "fields/field/field_file.h"
#include "tools/python/arrays.h"
#include "tools/python/scene.h"
#include "tools/python/trees.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

namespace haarfield::python {

namespace {

/// A field, regardless of its owner.
struct PythonField {
    std::shared_ptr<const VisibilityField> field;

    template <class Element>
    py::array view(const std::vector<Element>& elements) const {
        return view_of<Element>(elements, field);
    }
};

template <class Sampler>
py::array positions_of(const Sampler& sampler) {
    std::vector<Vec3f> positions(sampler.sample_count());
    for (std::uint32_t i = 0; i < positions.size(); ++i) positions[i] = sampler.sample_position(i);
    return array_of(std::move(positions));
}

py::dict error_of(const SamplerError& error) {
    py::dict result;
    result["relative"] = error.relative;
    result["band"] = array_of(std::vector<float>(error.band.begin(), error.band.end()));
    return result;
}

py::tuple tuple_of(const Vec3f& v) {
    return py::make_tuple(v.x, v.y, v.z);
}

py::dict planar_of(const PythonField& self) {
    const PlanarSampler& sampler = self.field->planar;
    py::dict result;
    result["centre"] = tuple_of(sampler.centre);
    result["rings"] = sampler.rings;
    result["angles"] = sampler.angles;
    result["outer_radius"] = sampler.outer_radius;
    result["growth"] = sampler.growth;
    result["positions"] = positions_of(sampler);
    result["handles"] = self.view(self.field->planar_handles);
    result["error"] = error_of(self.field->error.planar);
    return result;
}

py::dict spherical_of(const PythonField& self) {
    const SphericalSampler& sampler = self.field->spherical;
    py::dict result;
    result["centre"] = tuple_of(sampler.centre);
    result["shells"] = sampler.shells;
    result["polar"] = sampler.polar;
    result["azimuths"] = sampler.azimuths;
    result["outer_radius"] = sampler.outer_radius;
    result["growth"] = sampler.growth;
    result["positions"] = positions_of(sampler);
    result["handles"] = self.view(self.field->spherical_handles);
    result["error"] = error_of(self.field->error.spherical);
    return result;
}

CubemapTree cubemap_of(const VisibilityField& field, std::int64_t handle) {
    const QuadtreePool& pool = field.pool;
    if (handle < 0 || static_cast<std::uint64_t>(handle) >= pool.cubemaps.size())
        throw py::index_error(fmt::format("handle {}; expected less than {}", handle, pool.cubemaps.size()));
    CubemapTree tree;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        unpack_face(pool, pool.cubemaps[static_cast<std::size_t>(handle)][face], tree.faces[face]);
    return tree;
}

/// Returns the handles of a sampler, and the interpolation at a point.
std::pair<const std::vector<std::int32_t>*, Interpolation> looked_up(const VisibilityField& field,
                                                                     const py::object& point,
                                                                     const std::string& sampler) {
    const Vec3f place = vector(point, "point");
    if (sampler == "planar") return {&field.planar_handles, field.planar.interpolation(place)};
    if (sampler == "spherical") return {&field.spherical_handles, field.spherical.interpolation(place)};
    throw py::value_error(fmt::format("sampler is \"{}\"; expected \"planar\" or \"spherical\"", sampler));
}

PythonTree tree_at(const PythonField& self, const py::object& point, const std::string& sampler) {
    const VisibilityField& field = *self.field;
    const auto [handles, interpolation] = looked_up(field, point, sampler);
    return {interpolated_visibility(field, *handles, interpolation), field.pool.face_size};
}

py::dict interpolation_at(const PythonField& self, const py::object& point, const std::string& sampler) {
    const auto [handles, found] = looked_up(*self.field, point, sampler);
    const auto count = found.sample.begin() + found.count;
    std::vector<std::int32_t> of_samples;
    for (auto sample = found.sample.begin(); sample != count; ++sample)
        of_samples.push_back((*handles)[*sample]);
    py::dict result;
    result["samples"] = array_of(std::vector<std::uint32_t>(found.sample.begin(), count));
    result["weights"] =
        array_of(std::vector<float>(found.weight.begin(), found.weight.begin() + found.count));
    result["handles"] = array_of(std::move(of_samples));
    result["open"] = found.open;
    return result;
}

PythonField field_of(PythonScene& scene, const std::string& entity, const py::object& progress) {
    const auto prepared = prepare(scene, progress);
    std::vector<std::string> names;
    for (const auto& found : prepared->entities->entities) {
        if (found->name == entity) return {{prepared, &found->field}};
        names.push_back(found->name);
    }
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    throw py::key_error(fmt::format("unknown entity \"{}\"; expected one of: {}", entity, known));
}

}  // namespace

void add_field(py::module_& module, py::class_<PythonScene, std::shared_ptr<PythonScene>>& scene) {
    py::class_<PythonField> field(
        module, "Field",
        R"(The precomputed visibility around one entity: cubemaps as quadtrees of Haar wavelets.

Visibility is 1 where a direction is unoccluded and 0 where the entity blocks it. A handle is the index of a cubemap;
equal cubemaps are stored once. Points are in the entity's frame, in metres.)");
    field.def_property_readonly(
        "entity", [](const PythonField& self) { return self.field->entity; }, "The entity's name.");
    field.def_property_readonly(
        "key", [](const PythonField& self) { return self.field->keys.whole.hex(); },
        "A hash of mesh, settings and format.");
    field.def_property_readonly(
        "face_size", [](const PythonField& self) { return self.field->pool.face_size; },
        "Texels along an edge of the cubemaps.");
    field.def_property_readonly(
        "bounds",
        [](const PythonField& self) {
            return py::make_tuple(tuple_of(self.field->bounds.lower), tuple_of(self.field->bounds.upper));
        },
        "Two corners of the mesh's bounding box, in metres.");
    field.def_property_readonly("planar", &planar_of,
                                "The samples on the ground, on rings: a dict of centre, rings, angles, "
                                "outer_radius, growth,\npositions (n, 3), handles (n,), error.");
    field.def_property_readonly(
        "spherical", &spherical_of,
        "The samples around the entity, on shells: a dict of centre, shells, polar, azimuths, "
        "outer_radius,\ngrowth, positions (n, 3), handles (n,), error.");
    field.def_property_readonly(
        "local_handles", [](const PythonField& self) { return self.view(self.field->local_handles); },
        "(n,): the visibility at each vertex of the fine mesh, as occluded by its own object.");
    field.def_property_readonly(
        "cubemaps", [](const PythonField& self) { return self.field->pool.cubemaps.size(); },
        "The number of cubemaps: handles are 0 to cubemaps - 1.");
    field.def_property_readonly(
        "nodes", [](const PythonField& self) { return node_count(self.field->pool); },
        "The number of nodes of all quadtrees.");
    field.def_property_readonly(
        "bytes",
        [](const PythonField& self) {
            const SharedArray<std::uint8_t>& bytes = self.field->pool.node_bytes;
            return view_of<std::uint8_t>({bytes.data(), bytes.size()}, self.field);
        },
        "The packed nodes, (n,) bytes: a view of the mapped file.");
    field.def(
        "visibility",
        [](const PythonField& self, const py::object& point, const std::string& sampler) {
            const PythonTree tree = tree_at(self, point, sampler);
            return texels_of(tree.trees, tree.size);
        },
        py::arg("point"), py::arg("sampler") = "spherical",
        R"(Visibility at a point, interpolated between samples: (6, N, N), faces +x -x +y -y +z -z, row 0 on top.

sampler  "spherical", or "planar" for points on the ground.)");
    field.def("tree", &tree_at, py::arg("point"), py::arg("sampler") = "spherical",
              "Returns visibility() as a CubemapTree, for products with other functions.");
    field.def(
        "interpolation", &interpolation_at, py::arg("point"), py::arg("sampler") = "spherical",
        "Returns the samples between which a point is interpolated: a dict of samples, weights, handles, "
        "and open,\nthe weight of an unoccluded sample.");
    field.def(
        "cubemap",
        [](const PythonField& self, std::int64_t handle) {
            return PythonTree{cubemap_of(*self.field, handle), self.field->pool.face_size};
        },
        py::arg("handle"), "The cubemap of a handle, as a CubemapTree.");
    field.def("__repr__", [](const PythonField& self) {
        return fmt::format("<haarfield.Field of \"{}\": {} cubemaps of 6 x {} x {} texels>",
                           self.field->entity, self.field->pool.cubemaps.size(), self.field->pool.face_size,
                           self.field->pool.face_size);
    });
    module.def(
        "read_field",
        [](const std::filesystem::path& path) {
            auto read =
                long_call<VisibilityField>(py::none(), [&](const Progress&) { return read_field(path); });
            return PythonField{std::make_shared<const VisibilityField>(std::move(read))};
        },
        py::arg("path"), "Reads and verifies a field file.");
    scene.def("field", &field_of, py::arg("entity"), py::arg("progress") = py::none(),
              "The field of an entity of the scene.");
}

}  // namespace haarfield::python
