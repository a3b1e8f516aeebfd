#include "tools/python/tables.h"

#include "scenes/image.h"
#include "tools/python/arrays.h"
#include "tools/python/long_call.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

namespace haarfield::python {

namespace {

/// Returns an image file of texels in 8 bit sRGB. Bytes are stored unchanged; floats are linear.
std::string image_file_of(const py::array& texels, const std::string& name) {
    const bool is_bytes = texels.dtype().kind() == 'u' && texels.itemsize() == 1;
    if (texels.ndim() != 3 || (texels.shape(2) != 3 && texels.shape(2) != 4) || texels.size() == 0)
        throw py::value_error(
            fmt::format("{} has the shape {}; expected (height, width, 3 or 4)", name, shape_text(texels)));
    const FloatArray values = floats(texels, name, {any_length, any_length, any_length});
    const auto channels = static_cast<std::size_t>(texels.shape(2));
    std::vector<std::array<std::uint8_t, 4>> bytes(static_cast<std::size_t>(texels.size()) / channels,
                                                   {255, 255, 255, 255});
    for (std::size_t i = 0; i < bytes.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) {
            const float value = values.data()[i * channels + c];
            bytes[i][c] =
                is_bytes ? static_cast<std::uint8_t>(value) : unit_byte(c < 3 ? srgb_encoded(value) : value);
        }
    return value_of(png_bytes(bytes, static_cast<int>(texels.shape(1)), static_cast<int>(texels.shape(0)),
                              channels == 4));
}

LatLongImage environment_of(const py::array& pixels, const std::string& name) {
    // The environment is cleaned later, with a count of the repaired pixels, as for files.
    const auto values = FloatArray::ensure(pixels);
    if (!values || values.ndim() != 3 || values.shape(2) != 3 || values.shape(0) == 0 ||
        values.shape(1) != 2 * values.shape(0))
        throw py::value_error(fmt::format(
            "{} has the shape {}; expected (height, 2 height, 3): a lat-long image is twice as wide "
            "as high",
            name, shape_text(pixels)));
    LatLongImage image{static_cast<int>(values.shape(1)), static_cast<int>(values.shape(0)), {}};
    image.pixels.resize(static_cast<std::size_t>(values.size()) / 3);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = Rgb(values.data()[3 * i], values.data()[3 * i + 1], values.data()[3 * i + 2]);
    return image;
}

/// Returns a name that no given mesh or image has.
std::string new_name(const std::string& place, const FilesInMemory& given) {
    std::string name = place;
    for (int number = 2; names_of(given).contains(name); ++number) name = fmt::format("{} {}", place, number);
    return name;
}

/// Converts Python values into tables.
class TableWriter {
public:
    explicit TableWriter(FilesInMemory& given) : given_(given) {}

    void change(const py::dict& changes, toml::table& table, const std::string& place) {
        for (const auto& [name, value] : changes) {
            if (!py::isinstance<py::str>(name))
                throw py::type_error(fmt::format("{} has the key {}; expected texts",
                                                 place.empty() ? "the scene" : place,
                                                 py::repr(name).cast<std::string>()));
            const auto key = name.cast<std::string>();
            const std::string here = place.empty() ? key : place + "." + key;
            if (value.is_none()) {
                table.erase(key);
            } else if (py::isinstance<py::dict>(value)) {
                if (table.get(key) == nullptr || !table.get(key)->is_table())
                    table.insert_or_assign(key, toml::table{});
                change(value.cast<py::dict>(), *table.get_as<toml::table>(key), here);
            } else {
                toml::array made;
                add(value, here, key, made);
                made.get(0)->visit([&](auto& node) { table.insert_or_assign(key, std::move(node)); });
            }
        }
    }

private:
    /// Appends a value.
    void add(const py::handle& value, const std::string& place, const std::string& key, toml::array& to) {
        if (py::isinstance<py::bool_>(value)) return to.push_back(value.cast<bool>());
        if (py::isinstance<py::int_>(value)) return to.push_back(value.cast<std::int64_t>());
        if (py::isinstance<py::float_>(value)) return to.push_back(value.cast<double>());
        if (py::isinstance<py::str>(value)) return to.push_back(value.cast<std::string>());
        if (py::hasattr(value, "__fspath__"))
            return to.push_back(py::str(value.attr("__fspath__")()).cast<std::string>());
        if (py::isinstance<ArrayMesh>(value))
            return to.push_back(mesh(value.cast<const ArrayMesh&>(), place));
        if (py::isinstance<py::array>(value)) {
            const auto array = py::reinterpret_borrow<py::array>(value);
            if (key == "image") return to.push_back(image(array, place));
            return add(array.attr("tolist")(), place, key, to);
        }
        if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) {
            toml::array list;
            std::size_t number = 0;
            for (const py::handle element : value) {
                const std::string here = fmt::format("{}[{}]", place, number++);
                if (!py::isinstance<py::dict>(element)) {
                    add(element, here, key, list);
                    continue;
                }
                toml::table table;
                change(py::reinterpret_borrow<py::dict>(element), table, here);
                list.push_back(std::move(table));
            }
            return to.push_back(std::move(list));
        }
        if (py::hasattr(value, "item") && py::hasattr(value, "dtype"))  // numbers of numpy
            return add(value.attr("item")(), place, key, to);
        throw py::type_error(fmt::format(
            "{} is of type {}; expected a number, a text, True or False, a list, a dict, a Mesh, or "
            "an array for an image",
            place, py::str(py::type::of(value).attr("__name__")).cast<std::string>()));
    }

    std::string mesh(const ArrayMesh& made, const std::string& place) {
        const std::string name = new_name(place, given_);
        given_.meshes[name] = std::make_shared<const ModelFile>(ModelFile::of(*made.mesh, name));
        return name;
    }

    std::string image(const py::array& pixels, const std::string& place) {
        const std::string name = new_name(place, given_);
        if (place.starts_with("environment"))
            given_.environments[name] = std::make_shared<const LatLongImage>(environment_of(pixels, place));
        else
            given_.images[name] = std::make_shared<const std::string>(image_file_of(pixels, place));
        return name;
    }

    FilesInMemory& given_;
};

/// Returns the texels of a PNG image: linear, with alpha if present.
py::array texels_of(const std::string& bytes, const std::string& name) {
    const Image image = value_of(read_image_bytes(bytes, name));
    const std::size_t channels = image.coverage.empty() ? 3 : 4;
    std::vector<float> texels;
    texels.reserve(image.pixels.size() * channels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c) texels.push_back(image.pixels[i][c]);
        if (channels == 4) texels.push_back(image.coverage[i]);
    }
    return array_of(std::move(texels), {image.height, image.width, static_cast<py::ssize_t>(channels)});
}

/// Returns the mesh or image that is given under a name; otherwise the text itself.
py::object given_or_text(const std::string& key, const std::string& text, const FilesInMemory& given) {
    if (const auto mesh = given.meshes.find(text); key == "mesh" && mesh != given.meshes.end())
        return py::cast(ArrayMesh{{mesh->second, mesh->second->given()}});
    if (key != "image") return py::str(text);
    if (const auto image = given.images.find(text); image != given.images.end())
        return texels_of(*image->second, text);
    if (const auto light = given.environments.find(text); light != given.environments.end())
        return view_of<Rgb>(light->second->pixels, light->second,
                            {light->second->height, light->second->width});
    return py::str(text);
}

py::object object_of(const std::string& key, const toml::node& node, const FilesInMemory& given) {
    if (const auto* table = node.as_table()) return dict_of(*table, given);
    if (const auto* text = node.as_string()) return given_or_text(key, text->get(), given);
    if (const auto* integer = node.as_integer()) return py::int_(integer->get());
    if (const auto* real = node.as_floating_point()) return py::float_(real->get());
    if (const auto* boolean = node.as_boolean()) return py::bool_(boolean->get());
    py::list list;
    if (const auto* array = node.as_array())
        for (const toml::node& element : *array) list.append(object_of(key, element, given));
    return list;
}

ArrayMesh mesh_of(const py::object& positions, const py::object& triangles, const py::object& normals,
                  const py::object& uvs, const py::object& colours, std::vector<std::string> materials,
                  const py::object& triangle_materials) {
    MeshInMemory mesh;
    mesh.positions = vectors<Vec3f>(positions, "positions");
    const auto count = static_cast<py::ssize_t>(mesh.positions.size());
    const auto corners = indices(triangles, "triangles", {any_length, 3}, mesh.positions.size());
    mesh.triangles.resize(static_cast<std::size_t>(corners.shape(0)));
    if (mesh.triangles.empty()) throw py::value_error("triangles is empty; expected at least one");
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) mesh.triangles[i][k] = corners.data()[3 * i + k];
    if (!normals.is_none()) mesh.normals = vectors<Vec3f>(normals, "normals", count);
    if (!uvs.is_none()) mesh.uvs = vectors<Vec2f>(uvs, "uvs", count);
    if (!colours.is_none()) mesh.colours = vectors<Rgb>(colours, "colours", count);
    if (materials.empty()) throw py::value_error("materials is empty; expected at least one name");
    mesh.material_names = std::move(materials);
    if (!triangle_materials.is_none()) {
        const auto of =
            indices(triangle_materials, "triangle_materials", {corners.shape(0)}, mesh.material_names.size());
        mesh.triangle_materials.assign(of.data(), of.data() + of.size());
    }
    return {std::make_shared<const MeshInMemory>(std::move(mesh))};
}

}  // namespace

void change_tables(const py::dict& changes, toml::table& tables, FilesInMemory& given) {
    TableWriter(given).change(changes, tables, "");
}

py::dict dict_of(const toml::table& tables, const FilesInMemory& given) {
    py::dict dict;
    for (const auto& [key, value] : tables) {
        const std::string name(key.str());
        dict[py::str(name)] = object_of(name, value, given);
    }
    return dict;
}

void add_mesh(py::module_& module) {
    py::class_<ArrayMesh> mesh(module, "Mesh",
                               R"(A mesh of arrays that replaces a mesh file in a scene.

positions           (N, 3), metres, +y up.
triangles           (M, 3) indices of positions, counter-clockwise seen from outside.
normals             (N, 3) of any length, or None: smoothed over edges of less than 35 degrees.
uvs                 (N, 2), (0, 0) is an image's lower left; for materials with images.
colours             (N, 3), linear, multiplied with the diffuse colour if no material is named.
materials           names that an entity's `materials` maps to materials of the scene.
triangle_materials  (M,) indices of materials, or None: the first.

The mesh is repaired like that of a file: except for polygons, all meshes that `haarfield bake` accepts are valid.)");
    mesh.def(py::init(&mesh_of), py::arg("positions"), py::arg("triangles"), py::arg("normals") = py::none(),
             py::arg("uvs") = py::none(), py::arg("colours") = py::none(),
             py::arg("materials") = std::vector<std::string>{""}, py::arg("triangle_materials") = py::none());
    mesh.def("__repr__", [](const ArrayMesh& self) {
        return fmt::format("<haarfield.Mesh of {} vertices and {} triangles>", self.mesh->positions.size(),
                           self.mesh->triangles.size());
    });
}

}  // namespace haarfield::python
