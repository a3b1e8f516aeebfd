#include "tools/view/light_shelf.h"

#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"
#include "scenes/image_format.h"
#include "scenes/scene_environment.h"
#include "shading/scene/exposure.h"
#include "tools/view/message_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace haarfield {
namespace {

constexpr int thumbnail_width = 192, widest_background = 2048;  ///< [pixels]

bool is_same_sky(const AnalyticSky& a, const AnalyticSky& b) {
    return a.turbidity == b.turbidity && a.sun_elevation == b.sun_elevation &&
           a.sun_azimuth == b.sun_azimuth && a.sun_angular_radius == b.sun_angular_radius &&
           a.ground == b.ground;
}

bool is_light_file(const std::filesystem::path& file) {
    const std::string ending = lower_ending(file);
    return ending == ".exr" || ending == ".hdr";
}

Result<Environment> environment_of(const ShelfLight& light) {
    Scene scene;
    scene.environment.image = light.image;
    scene.environment.sky = light.sky;
    std::vector<std::string> ignored;
    return described_environment(scene, ignored);
}

/// Returns an image that is reduced by averaging `factor` by `factor` pixels.
LatLongImage reduced(const LatLongImage& image, int factor) {
    LatLongImage small{image.width / factor, image.height / factor, {}};
    const auto width = std::size_t(image.width);
    for (int row = 0; row < small.height; ++row)
        for (int column = 0; column < small.width; ++column) {
            Rgb sum(0.0f);
            for (int y = 0; y < factor; ++y)
                for (int x = 0; x < factor; ++x)
                    sum +=
                        image
                            .pixels[std::size_t(row * factor + y) * width + std::size_t(column * factor + x)];
            small.pixels.push_back(sum / static_cast<float>(factor * factor));
        }
    return small;
}

int factor_to(int width, int widest) {
    return std::max(1, (width + widest - 1) / widest);
}

}  // namespace

LightShelf::LightShelf(const EnvironmentDescription& scene, const std::filesystem::path& folder,
                       std::filesystem::path uploads)
    : uploads_(std::move(uploads)) {
    put(scene.sky ? "sky" : scene.image.filename().string(), scene.image, scene.sky);
    if (scene.blend)
        put(scene.blend->sky ? "sky" : scene.blend->image.filename().string(), scene.blend->image,
            scene.blend->sky);
    std::error_code ignored;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
        if (entry.is_regular_file(ignored) && is_light_file(entry.path())) files.push_back(entry.path());
    std::ranges::sort(files);
    for (const std::filesystem::path& file : files) put(file.filename().string(), file, {});
    const auto is_sky = [](const ShelfLight& light) { return light.sky.has_value(); };
    if (std::ranges::none_of(lights_, is_sky)) put("sky", {}, AnalyticSky{});
}

void LightShelf::put(std::string name, std::filesystem::path image, std::optional<AnalyticSky> sky) {
    std::set<std::string> taken;
    std::error_code ignored;
    for (const ShelfLight& light : lights_) {
        if (!image.empty() && std::filesystem::equivalent(light.image, image, ignored)) return;
        taken.insert(light.name);
    }
    lights_.push_back({unique_name(name, taken), std::move(image), std::move(sky)});
}

std::vector<ShelfLight> LightShelf::lights() const {
    const std::lock_guard lock(mutex_);
    return lights_;
}

std::optional<ShelfLight> LightShelf::find(std::string_view name) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(lights_, name, &ShelfLight::name);
    if (found == lights_.end()) return std::nullopt;
    return *found;
}

void LightShelf::set_sky(const AnalyticSky& sky) {
    const std::lock_guard lock(mutex_);
    if (std::ranges::any_of(
            lights_, [&](const ShelfLight& light) { return light.sky && is_same_sky(*light.sky, sky); }))
        return;
    const auto first =
        std::ranges::find_if(lights_, [](const ShelfLight& light) { return light.sky.has_value(); });
    if (first != lights_.end()) first->sky = sky;
}

std::string LightShelf::name_of(const std::filesystem::path& image,
                                const std::optional<AnalyticSky>& sky) const {
    const std::lock_guard lock(mutex_);
    for (const ShelfLight& light : lights_)
        if (sky ? light.sky && is_same_sky(*sky, *light.sky) : !light.sky && light.image == image)
            return light.name;
    std::error_code ignored;
    for (const ShelfLight& light : lights_)
        if (!sky && !light.sky && std::filesystem::equivalent(light.image, image, ignored)) return light.name;
    return {};
}

Result<std::string> LightShelf::add(std::string_view name, std::string_view bytes) {
    const std::string plain = plain_name(std::filesystem::path(name).filename().string());
    if (plain.empty() || plain.front() == '.' || plain.size() > 100)
        return Error{"", "found an invalid file name; expected 1 to 100 characters, the first not a dot"};
    if (image_plugin(bytes) == nullptr)
        return Error{plain, fmt::format("found no image; expected a lat-long image ({})", image_formats)};
    const std::lock_guard lock(mutex_);
    HF_TRY_DONE(make_folder(uploads_));
    std::error_code ignored;
    const std::filesystem::path file = uploads_ / free_name(plain);
    HF_TRY_DONE(write_file(file, bytes));
    if (const Result<LatLongImage> read = read_environment_image(file); !read) {
        std::filesystem::remove(file, ignored);
        return Error{plain, read.error().what};
    }
    put(file.filename().string(), file, {});
    return lights_.back().name;
}

/// Adds a number to the stem, so that the file keeps its extension: `sky_2.hdr`.
std::string LightShelf::free_name(const std::filesystem::path& wanted) const {
    std::set<std::string> stems;
    for (const ShelfLight& light : lights_) stems.insert(std::filesystem::path(light.name).stem().string());
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(uploads_, ignored))
        stems.insert(entry.path().stem().string());
    return unique_name(wanted.stem().string(), stems) + wanted.extension().string();
}

Result<std::string> thumbnail_png(const ShelfLight& light) {
    HF_TRY(const Environment environment, environment_of(light));
    const LatLongImage whole = image_with_suns(environment);
    LatLongImage small = reduced(whole, std::max(1, whole.width / thumbnail_width));
    const float gain = std::exp2(automatic_exposure(environment));
    for (Rgb& pixel : small.pixels) pixel *= gain;
    return png_bytes(Image{small.width, small.height, std::move(small.pixels), {}});
}

Result<std::string> background_bytes(const ShelfLight& light) {
    HF_TRY(const Environment environment, environment_of(light));
    LatLongImage image = image_with_suns(environment);
    if (image.width > widest_background) image = reduced(image, factor_to(image.width, widest_background));
    std::string bytes;
    bytes.reserve(8 + image.pixels.size() * 8);
    append(bytes, static_cast<std::uint32_t>(image.width));
    append(bytes, static_cast<std::uint32_t>(image.height));
    for (const Rgb& pixel : image.pixels) {
        for (const float value : {pixel.x, pixel.y, pixel.z}) append(bytes, half_bits(value));
        append(bytes, half_bits(1));
    }
    return bytes;
}

}  // namespace haarfield
