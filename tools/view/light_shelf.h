#pragma once
/// The lights that a page can choose from, by name and never by path.

#include "scenes/scene.h"

#include <mutex>

namespace haarfield {

/// A selectable light.
struct ShelfLight {
    std::string name;             ///< The name that pages use.
    std::filesystem::path image;  ///< Empty for a sky.
    std::optional<AnalyticSky> sky;
};

/// The lights of the scene and of a folder, and uploaded ones. Thread-safe.
class LightShelf {
public:
    /// folder   its .exr and .hdr files are offered by name; empty: none. A sky is always offered.
    /// uploads  the folder of uploaded lights, created for the first one.
    LightShelf(const EnvironmentDescription& scene, const std::filesystem::path& folder,
               std::filesystem::path uploads);

    std::vector<ShelfLight> lights() const;  ///< Returns all lights in order.
    std::optional<ShelfLight> find(std::string_view name) const;
    /// Replaces the shelf's first sky, unless the shelf has this one.
    void set_sky(const AnalyticSky& sky);
    /// Returns the name of an image or a sky; empty if the shelf does not have it.
    std::string name_of(const std::filesystem::path& image, const std::optional<AnalyticSky>& sky) const;

    /// Stores an uploaded panorama. Returns its name on the shelf.
    ///
    /// name    the file name. A number is added to its stem if the shelf has a light with this stem.
    /// bytes   a lat-long image in one of image_formats. 8 and 16 bit integers are sRGB, floats linear.
    /// errors  an invalid name; not a lat-long image (nothing is stored); I/O errors.
    Result<std::string> add(std::string_view name, std::string_view bytes);

private:
    void put(std::string name, std::filesystem::path image, std::optional<AnalyticSky> sky);
    std::string free_name(const std::filesystem::path& wanted) const;

    mutable std::mutex mutex_;
    std::vector<ShelfLight> lights_;
    std::filesystem::path uploads_;
};

/// Returns a small picture of a light with its automatic exposure, as the bytes of a PNG.
///
/// cost    reading the light: about 0.1 s for 2048 x 1024 pixels.
/// errors  of reading the light.
Result<std::string> thumbnail_png(const ShelfLight& light);

/// Returns the background of a page: width and height (32 bit), then four half floats per pixel (red, green,
/// blue and 1), rows from the top. Little-endian. Images wider than 2048 pixels are reduced by averaging
/// pixels.
///
/// errors  of reading the light.
Result<std::string> background_bytes(const ShelfLight& light);

}  // namespace haarfield
