/// Haar wavelets, product integrals and function products of arrays in Python.

#include "scenes/image.h"
#include "shading/scene/lighting.h"
#include "shading/scene/lobes.h"
#include "shading/walk/product_integral.h"
#include "tools/python/arrays.h"
#include "tools/python/scene.h"
#include "tools/python/trees.h"

#include <fmt/format.h>

namespace haarfield::python {

namespace {

int checked_size(py::ssize_t size, const std::string& name) {
    if (size < 1 || size > 256 || !is_face_size(static_cast<int>(size)))
        throw py::value_error(
            fmt::format("{} has {} texels along an edge; expected 1, 2, 4 ... 256", name, size));
    return static_cast<int>(size);
}

Truncation truncation(int coefficients, float relative_l2_error) {
    if (coefficients < 0)
        throw py::value_error(fmt::format("coefficients is {}; expected 0 or more", coefficients));
    if (!(relative_l2_error >= 0 && relative_l2_error < 1))
        throw py::value_error(fmt::format("relative_l2_error is {}; expected [0, 1)", relative_l2_error));
    return {coefficients, relative_l2_error};
}

PythonTree tree_of(const py::object& texels, int coefficients, float relative_l2_error,
                   const std::string& name = "texels") {
    const FloatArray array = floats(texels, name, {cubemap_faces, any_length, any_length});
    const int size = checked_size(array.shape(1), name);
    if (array.shape(2) != size)
        throw py::value_error(
            fmt::format("{} has the shape {}; expected (6, N, N)", name, shape_text(array)));
    return {haar_cubemap<float>({array.data(), static_cast<std::size_t>(array.size())}, size,
                                truncation(coefficients, relative_l2_error)),
            size};
}

/// The factors of a product, and their number of texels.
class Factors {
public:
    explicit Factors(const py::args& functions) {
        for (std::size_t i = 0; i < functions.size(); ++i) {
            const std::string name = fmt::format("functions[{}]", i);
            const py::object function = functions[i];
            if (py::isinstance<PythonTree>(function)) {
                const auto& tree = function.cast<const PythonTree&>();
                take_size(tree.size, name);
                trees_.emplace_back(tree.trees);
            } else {
                const PythonTree tree = tree_of(function, 0, 0, name);
                take_size(tree.size, name);
                trees_.emplace_back(tree.trees);
            }
        }
        for (const WideCubemapTree& tree : trees_) factors_.push_back(tree.factor());
    }

    void take_size(int size, const std::string& name) {
        if (size_ != 0 && size != size_)
            throw py::value_error(fmt::format(
                "{} has {} texels along an edge; expected {} like the functions before", name, size, size_));
        size_ = size;
    }

    int size() const { return size_; }
    std::span<const WeightedTrees<float>> factors() const { return factors_; }

private:
    std::vector<WideCubemapTree> trees_;
    std::vector<WeightedTrees<float>> factors_;
    int size_ = 0;
};

int checked_depth(int depth) {
    if (depth < 0) throw py::value_error(fmt::format("depth is {}; expected 0 or more", depth));
    return depth;
}

LightPyramid pyramid_of(const py::object& light, int& size) {
    const FloatArray array = floats(light, "light", {cubemap_faces, any_length, any_length, 3});
    size = checked_size(array.shape(1), "light");
    if (array.shape(2) != size)
        throw py::value_error(
            fmt::format("light has the shape {}; expected (6, N, N, 3)", shape_text(array)));
    const auto* texels = reinterpret_cast<const Rgb*>(array.data());
    return {haar_cubemap<Rgb>({texels, static_cast<std::size_t>(array.size()) / 3}, size), size};
}

py::object product_integral_of(const py::args& functions, const py::object& light, int depth) {
    Factors factors(functions);
    WalkMemory<float> memory;
    if (light.is_none()) {
        if (factors.size() == 0) return py::float_(double(cubemap_faces));
        return py::float_(
            double(product_integral(factors.size(), factors.factors(), checked_depth(depth), memory)));
    }
    int size = 0;
    const LightPyramid pyramid = pyramid_of(light, size);
    factors.take_size(size, "light");
    const Rgb integral = product_integral(pyramid, factors.factors(), checked_depth(depth), memory);
    return array_of(std::vector<float>{integral.x, integral.y, integral.z});
}

PythonTree function_product_of(const py::args& functions, int depth) {
    const Factors factors(functions);
    if (factors.size() == 0) throw py::type_error("found no function; expected at least one");
    WalkMemory<float> memory;
    std::vector<WaveletBlock<1>> blocks;
    function_product(factors.size(), factors.factors(), checked_depth(depth), memory, blocks);
    return {cubemap_tree(blocks), factors.size()};
}

/// Returns the complete transform of one face: the amplitudes of every level.
py::tuple haar_transform_of(const py::object& texels) {
    const FloatArray array = floats(texels, "texels", {any_length, any_length});
    const int size = checked_size(array.shape(0), "texels");
    if (array.shape(1) != size)
        throw py::value_error(fmt::format("texels has the shape {}; expected (N, N)", shape_text(array)));
    const Quadtree tree = haar_quadtree<float>({array.data(), static_cast<std::size_t>(array.size())}, size);
    py::list levels;
    std::vector<std::int32_t> squares{tree.nodes.empty() ? no_node : 0};  // of a level, row by row
    for (int width = 1; width < size; width *= 2) {
        const auto w = static_cast<std::size_t>(width);
        std::vector<float> amplitudes(3 * w * w, 0.0f);
        std::vector<std::int32_t> next(4 * w * w, no_node);
        for (std::size_t y = 0; y < w; ++y)
            for (std::size_t x = 0; x < w; ++x) {
                const std::int32_t square = squares[y * w + x];
                if (square == no_node) continue;
                const Quadtree::Node& node = tree.nodes[static_cast<std::size_t>(square)];
                for (std::size_t k = 0; k < 3; ++k) amplitudes[(k * w + y) * w + x] = node.wavelet[k];
                for (unsigned q = 0; q < 4; ++q)
                    next[(2 * y + q / 2) * 2 * w + 2 * x + q % 2] = child_of(node, q);
            }
        levels.append(array_of(std::move(amplitudes), {3, width, width}));
        squares = std::move(next);
    }
    return py::make_tuple(tree.scaling, levels);
}

/// Returns the inverse transform, level by level.
py::array inverse_haar_transform_of(float scaling, const py::list& levels) {
    std::vector<float> means{scaling};
    py::ssize_t width = 1;
    for (std::size_t l = 0; l < levels.size(); ++l, width *= 2) {
        if (width > 128) throw py::value_error("levels has more than 8 elements; expected at most 8");
        const FloatArray amplitudes = floats(levels[l], fmt::format("levels[{}]", l), {3, width, width});
        const auto w = static_cast<std::size_t>(width);
        std::vector<float> finer(4 * w * w);
        for (std::size_t y = 0; y < w; ++y)
            for (std::size_t x = 0; x < w; ++x)
                for (unsigned q = 0; q < 4; ++q) {
                    const std::array<float, 3> wavelet{amplitudes.at(0, y, x), amplitudes.at(1, y, x),
                                                       amplitudes.at(2, y, x)};
                    finer[(2 * y + q / 2) * 2 * w + 2 * x + q % 2] =
                        quadrant_mean(means[y * w + x], wavelet, q);
                }
        means = std::move(finer);
    }
    return array_of(std::move(means), {width, width});
}

py::array directions_of(int size) {
    const int checked = checked_size(size, "size");
    return array_of(texel_directions(checked), {cubemap_faces, size, size});
}

py::array solid_angles_of(int size) {
    checked_size(size, "size");
    std::vector<double> angles;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) angles.push_back(texel_solid_angle(column, row, size));
    return array_of(std::move(angles), {size, size});
}

py::array lobe_of(float exponent, const py::object& axis, int size) {
    const Vec3f about = vector(axis, "axis");
    if (!(about.length() > 0)) throw py::value_error("axis is (0, 0, 0); expected a direction");
    if (!(exponent > 0 && exponent <= 1000))
        throw py::value_error(fmt::format("exponent is {}; expected (0, 1000]", exponent));
    checked_size(size, "size");
    return array_of(lobe_texels(exponent, about.normalized(), size), {cubemap_faces, size, size});
}

py::array lighting_of(const py::object& image, int size) {
    const FloatArray array = floats(image, "image", {any_length, any_length, 3});
    checked_size(size, "size");
    if (array.shape(0) == 0 || array.shape(1) != 2 * array.shape(0))
        throw py::value_error(
            fmt::format("image has the shape {}; expected (height, 2 height, 3)", shape_text(array)));
    LatLongImage lat_long{static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), {}};
    for (py::ssize_t i = 0; i < array.size(); i += 3)
        lat_long.pixels.emplace_back(array.data()[i], array.data()[i + 1], array.data()[i + 2]);
    clean_environment(lat_long);
    return array_of(lighting_texels(lat_long, size), {cubemap_faces, size, size});
}

void add_tree(py::module_& module) {
    py::class_<PythonTree> tree(
        module, "CubemapTree",
        R"(A function of direction, as one quadtree of Haar wavelets per face of a cube.

CubemapTree(texels) transforms (6, N, N) texels, N = 1, 2, 4 ... 256, faces +x -x +y -y +z -z, row 0 on top.

coefficients       maximum number of wavelets per face, the largest in L2; 0: all.
relative_l2_error  drop the smallest wavelets up to this fraction of the face's L2 norm.)");
    tree.def(py::init([](const py::object& texels, int coefficients, float relative_l2_error) {
                 return tree_of(texels, coefficients, relative_l2_error);
             }),
             py::arg("texels"), py::arg("coefficients") = 0, py::arg("relative_l2_error") = 0.0f);
    tree.def_property_readonly(
        "faces",
        [](const PythonTree& self) {
            py::list faces;
            for (const Quadtree& face : self.trees.faces) faces.append(arrays_of(face));
            return faces;
        },
        R"(Six dicts: scaling, the mean of the face; wavelets, (n, 3) amplitudes along x, along y, diagonal, root first,
level by level; children, (n, 4) rows of wavelets by quadrant 2y + x, -1 where the function is constant.

An amplitude is the contribution of the wavelet to f, in the unit of f. At level l (root: 0) the orthonormal
coefficient, with dA a fraction of the face, is amplitude * 2^-l.)");
    tree.def_property_readonly(
        "size", [](const PythonTree& self) { return self.size; }, "Texels along an edge.");
    tree.def_property_readonly(
        "nodes",
        [](const PythonTree& self) {
            std::size_t nodes = 0;
            for (const Quadtree& face : self.trees.faces) nodes += face.nodes.size();
            return nodes;
        },
        "The number of nodes of all six quadtrees.");
    tree.def(
        "texels", [](const PythonTree& self) { return texels_of(self.trees, self.size); },
        "Returns the inverse transform: (6, N, N).");
    tree.def("__repr__", [](const PythonTree& self) {
        return fmt::format("<haarfield.CubemapTree of 6 x {} x {} texels>", self.size, self.size);
    });
}

}  // namespace

py::dict arrays_of(const Quadtree& tree) {
    std::vector<std::array<float, 3>> wavelets;
    std::vector<std::array<std::int32_t, 4>> children;
    for (const Quadtree::Node& node : tree.nodes) {
        wavelets.push_back(node.wavelet);
        children.push_back({child_of(node, 0), child_of(node, 1), child_of(node, 2), child_of(node, 3)});
    }
    py::dict result;
    result["scaling"] = tree.scaling;
    result["wavelets"] = array_of(std::move(wavelets));
    result["children"] = array_of(std::move(children));
    return result;
}

py::array texels_of(const CubemapTree& tree, int size) {
    std::vector<float> texels;
    for (const Quadtree& face : tree.faces) {
        const std::vector<float> of_face = quadtree_texels<float>(face, size);
        texels.insert(texels.end(), of_face.begin(), of_face.end());
    }
    return array_of(std::move(texels), {cubemap_faces, size, size});
}

void add_mathematics(py::module_& module) {
    add_tree(module);
    module.def(
        "haar_transform", &haar_transform_of, py::arg("texels"),
        R"(Computes the non-standard Haar transform of one face: f = scaling + sum over levels of amplitude * (+-1).

texels   (N, N), row 0 on top, N = 1, 2, 4 ... 256.
returns  the mean of f, and for each level l = 0 ... log2(N) - 1 the amplitudes (3, 2^l, 2^l) of the wavelets along x
         (+ left, - right), along y (+ top, - bottom) and diagonal (+ - / - +) of its squares. With dA a fraction of
         the face the orthonormal coefficient is amplitude * 2^-l, and
             sum of texels^2 / N^2 = scaling^2 + sum over levels of sum of amplitude^2 * 4^-l.)");
    module.def("inverse_haar_transform", &inverse_haar_transform_of, py::arg("scaling"), py::arg("levels"),
               "Returns the texels (N, N) for a result of haar_transform.");
    module.def("product_integral", &product_integral_of, py::arg("light") = py::none(),
               py::arg("depth") = full_depth,
               R"(Computes the product integral of n functions of direction,

    I = int F_1 F_2 ... F_n dA,

summed over the six faces, with dA a fraction of a face: the integral over the sphere if one of the functions is
multiplied by solid_angles(N) * N^2. The integral is computed in wavelet space, without expanding the product (Sun and
Mukherjee 2006, section 5.1, in the form of shading/walk/product_integral.h): where at most one function varies on a
square, the integral of the product is the product of the means.

functions  any number of (6, N, N) arrays or CubemapTree, N = 1, 2, 4 ... 256. The product of no functions is 1.
light      a further factor with three channels: (6, N, N, 3). The result is then an array of three.
depth      wavelets at levels >= depth are ignored: coarser and faster.
accuracy   exact for the trees up to rounding: 1e-6 of the integral of the product's magnitude.)");
    module.def("function_product", &function_product_of, py::arg("depth") = full_depth,
               R"(Computes the function product of n functions of direction,

    G = F_1 F_2 ... F_n,

which is again a function, as the CubemapTree of its wavelets (Sun and Mukherjee 2006, section 5.2). Given G,
product_integral(G, L) is the integral of all n + 1 functions.

functions, depth  as in product_integral; one or more.)");
    module.def("texel_directions", &directions_of, py::arg("size"),
               "Returns the unit vectors of the texels' centres: (6, N, N, 3), faces +x -x +y -y +z -z as in "
               "OpenEXR.");
    module.def("solid_angles", &solid_angles_of, py::arg("size"),
               "Returns the exact solid angles of the texels of each face: (N, N). [sr]");
    module.def(
        "lobe", &lobe_of, py::arg("exponent"), py::arg("axis"), py::arg("size"),
        "Returns max(0, axis . w)^exponent, averaged over the texels: (6, N, N). The cosine of a normal has "
        "exponent 1.");
    module.def("lighting", &lighting_of, py::arg("image"), py::arg("size"),
               "Returns a lat-long image (height, 2 height, 3) as the light of product_integral:\n"
               "(6, N, N, 3), radiance times the texels' solid angle times N^2, so that integrals are over\n"
               "the sphere.");
}

}  // namespace haarfield::python
