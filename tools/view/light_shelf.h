#pragma once
/// The lights that a page can choose from: by name, never by path.

#include "scenes/scene.h"

#include <mutex>

namespace haarfield {

/// A light of the shelf.
struct ShelfLight {
    std::string name;             ///< What pages call it.
    std::filesystem::path image;  ///< Empty if it is a sky.
    std::optional<AnalyticSky> sky;
};

/// Lights of the scene, of a folder, and what pages send. From any thread.
class LightShelf {
public:
    /// folder   whose .exr and .hdr files are offered, by name; empty: none. A sky is always offered.
    /// uploads  where lights go that pages send; made when the first one comes.
    LightShelf(const EnvironmentDescription& scene, const std::filesystem::path& folder,
               std::filesystem::path uploads);

    std::vector<ShelfLight> lights() const;  ///< In order.
    std::optional<ShelfLight> find(std::string_view name) const;
    /// Replaces the shelf's first sky, unless the shelf has this one.
    void set_sky(const AnalyticSky& sky);
    /// The name of an image or a sky; empty if it is not on the shelf.
    std::string name_of(const std::filesystem::path& image, const std::optional<AnalyticSky>& sky) const;

    /// Stores a panorama that a page sends, and returns its name on the shelf.
    ///
    /// name    of the file; a number is added to its stem if the shelf has a light of that stem.
    /// bytes   a lat-long image in one of image_formats. 8 and 16 bit integers are sRGB, floats linear.
    /// errors  an unsuitable name; no lat-long image (then nothing is stored); errors of the file system.
    Result<std::string> add(std::string_view name, std::string_view bytes);

private:
    void put(std::string name, std::filesystem::path image, std::optional<AnalyticSky> sky);
    std::string free_name(const std::filesystem::path& wanted) const;

    mutable std::mutex mutex_;
    std::vector<ShelfLight> lights_;
    std::filesystem::path uploads_;
};

/// A small picture of a light, as its automatic exposure shows it: a PNG's bytes.
///
/// cost    reading the light, some 0.1 s for 2048 x 1024 pixels.
/// errors  of reading it.
Result<std::string> thumbnail_png(const ShelfLight& light);

/// What a page puts behind the scene: width and height as 32 bit, then half floats, red, green, blue and 1 a
/// pixel, rows from the top. At most 2048 pixels wide: others are means of so many. Little-endian.
///
/// errors  of reading the light.
Result<std::string> background_bytes(const ShelfLight& light);

}  // namespace haarfield
