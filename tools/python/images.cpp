#include "tools/python/images.h"

#include "bridge/pictures/image_difference.h"
#include "tools/python/arrays.h"
#include "tools/python/long_call.h"
#include "tools/python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

namespace haarfield::python {

namespace {

py::dict compare(const py::object& a, const py::object& b, const py::object& mask,
                 const py::object& progress) {
    const Image image = image_of(a, "a"), reference = image_of(b, "b");
    ImageDifferenceOptions options;
    if (!mask.is_none()) options.mask = image_of(mask, "mask");
    auto difference = long_call<ImageDifference>(
        progress, [&](const Progress&) { return image_difference(image, reference, options); });
    py::dict figures;
    figures["psnr_db"] = difference.psnr_db;
    figures["relative_rmse"] = difference.relative_rmse;
    figures["rmse"] = difference.rmse;
    figures["bias"] = difference.bias;
    figures["ssim"] = difference.ssim;
    figures["flip"] = difference.flip;
    figures["flip_99"] = difference.flip_99;
    figures["pixels"] = difference.pixels;
    if (reference.relative_error) figures["reference_relative_error"] = *reference.relative_error;
    figures["flip_errors"] = array_of(std::move(difference.flip_errors), {reference.height, reference.width});
    return figures;
}

}  // namespace

py::array pixels_of(const std::shared_ptr<const Image>& image) {
    return view_of<Rgb>(image->pixels, image, {image->height, image->width});
}

py::object coverage_of(const std::shared_ptr<const Image>& image) {
    if (image->coverage.empty()) return py::none();
    return view_of<float>(image->coverage, image, {image->height, image->width});
}

Image image_of(const py::object& picture, const std::string& name) {
    if (py::isinstance<py::str>(picture) || py::hasattr(picture, "__fspath__"))
        return value_of(read_image(picture.cast<std::filesystem::path>()));
    const auto array = py::array::ensure(picture);
    if (!array || array.ndim() != 3 || (array.shape(2) != 3 && array.shape(2) != 4) || array.size() == 0) {
        PyErr_Clear();
        throw py::value_error(
            fmt::format("{} is {}; expected the name of a picture file, or an array of (height, "
                        "width, 3), or 4 with coverage",
                        name, array ? "of shape " + shape_text(array) : "not an array"));
    }
    const FloatArray values = floats(array, name, {any_length, any_length, any_length});
    Image image;
    image.height = static_cast<int>(values.shape(0));
    image.width = static_cast<int>(values.shape(1));
    const auto channels = static_cast<std::size_t>(values.shape(2));
    const std::size_t count = static_cast<std::size_t>(values.size()) / channels;
    image.pixels.resize(count);
    if (channels == 4) image.coverage.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const float* pixel = values.data() + i * channels;
        image.pixels[i] = Rgb(pixel[0], pixel[1], pixel[2]);
        if (channels == 4) image.coverage[i] = std::clamp(pixel[3], 0.0f, 1.0f);
    }
    return image;
}

void add_images(py::module_& module) {
    module.def(
        "read_image",
        [](const std::filesystem::path& path) {
            const auto image = std::make_shared<const Image>(value_of(read_image(path)));
            return py::make_tuple(pixels_of(image), coverage_of(image));
        },
        py::arg("path"),
        "Reads a picture: linear radiance (height, width, 3), premultiplied by coverage, and coverage "
        "(height, width)\nin [0, 1], or None. Files of 8 and 16 bits are read as sRGB.");
    module.def(
        "write_image",
        [](const py::object& picture, const std::filesystem::path& path) {
            value_of(write_image(image_of(picture, "picture"), path));
        },
        py::arg("picture"), py::arg("path"),
        "Writes a picture: linear radiance of (height, width, 3), or 4 with coverage. .exr files have half "
        "floats,\n.png files are sRGB-encoded and clamped.");
    module.def("compare", &compare, py::arg("a"), py::arg("b"), py::arg("mask") = py::none(),
               py::arg("progress") = py::none(),
               R"(Compares a picture with a reference, like `haarfield compare`.

a, b     arrays of linear radiance, (height, width, 3), or 4 with coverage; or file names.
mask     only pixels at which this picture is bright are compared. a and b must also cover at least half of them.

returns  psnr_db (sRGB clamped to [0, 1]), relative_rmse and rmse (linear radiance), bias, ssim, flip, flip_99,
         pixels; reference_relative_error if b's file states it; flip_errors, (height, width).)");
}

}  // namespace haarfield::python
