#include "tools/farm/task_share.h"

#include "bridge/povray/povray_scene.h"

#include <fmt/format.h>

#include <cstring>
#include <memory>

namespace haarfield {
namespace {

template <class T>
std::string bytes_of(std::span<const T> values) {
    return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

/// Copies a section's values; returns false if the section is missing or has another size.
template <class T>
bool take_values(const std::vector<Section>& sections, const std::string& name, std::span<T> values) {
    const std::string* const bytes = section_named(sections, name);
    if (!bytes || bytes->size() != values.size_bytes()) return false;
    if (!bytes->empty()) std::memcpy(static_cast<void*>(values.data()), bytes->data(), bytes->size());
    return true;
}

Error wrong_part(std::size_t part, const std::string& section) {
    return {fmt::format("part {}", part),
            fmt::format("its {} are missing or have an unexpected number", section)};
}

/// A strip of the reference: its set of lights, and its rows, excluding last_row.
struct Strip {
    std::size_t set = 0;
    int first_row = 0, last_row = 0;
};

/// Returns the strip of a part. The first half of the parts belongs to the first set.
Strip strip_of(std::size_t part, std::size_t parts, int height) {
    const std::size_t of_set = parts / 2, strip = part % of_set,
                      units = static_cast<std::size_t>((height + strip_unit - 1) / strip_unit);
    const auto row = [&](std::size_t s) {
        return std::min(height, static_cast<int>(units * s / of_set) * strip_unit);
    };
    return {part / of_set, row(strip), row(strip + 1)};
}

std::span<Rgb> rows_of(Image& image, const Strip& strip) {
    const auto width = static_cast<std::size_t>(image.width);
    return std::span(image.pixels)
        .subspan(width * static_cast<std::size_t>(strip.first_row),
                 width * static_cast<std::size_t>(strip.last_row - strip.first_row));
}

std::span<float> coverage_rows_of(Image& image, const Strip& strip) {
    const auto width = static_cast<std::size_t>(image.width);
    return std::span(image.coverage)
        .subspan(width * static_cast<std::size_t>(strip.first_row),
                 width * static_cast<std::size_t>(strip.last_row - strip.first_row));
}

Result<ReferencePicture> rendered_strips(const ReferenceFiles& scene, const PovrayOptions& options,
                                         const Progress& progress, TaskShare& share) {
    for (std::size_t k = 0; k < share.count;) {
        const Strip first = strip_of(share.part + k, share.parts, options.height);
        std::vector<Strip> strips;  // of one set of lights: one run of POV-Ray
        for (; k < share.count; ++k) {
            const Strip strip = strip_of(share.part + k, share.parts, options.height);
            if (strip.set != first.set) break;
            strips.push_back(strip);
        }
        PovrayOptions rows = options;
        rows.first_row = first.first_row;
        rows.last_row = strips.back().last_row;
        HF_TRY(RenderedScene half, rendered_half(scene, first.set, rows, progress));
        Image& image = half.image;
        if (image.width != options.width || image.height != options.height || image.coverage.empty())
            return Error{scene.scene.string(),
                         "POV-Ray wrote a picture of an unexpected size or without alpha"};
        for (std::size_t i = 0; i < strips.size(); ++i) {
            std::vector<Section>& made = share.made[k - strips.size() + i];
            made.push_back({"pixels", bytes_of<Rgb>(rows_of(image, strips[i]))});
            made.push_back({"coverage", bytes_of<float>(coverage_rows_of(image, strips[i]))});
        }
    }
    return ReferencePicture{};
}

}  // namespace

std::string part_folder(std::size_t k) {
    return fmt::format("part_{}", k);
}

PointSharing point_sharing(TaskShare& share) {
    const auto run = [&share, number = std::make_shared<int>(0)](const SharedLoop& loop) -> Result<Done> {
        const std::string name = fmt::format("points of loop {}", (*number)++);
        if (!share.joins) {
            const auto [begin, end] = share.range(loop.points);
            std::vector<Outgoing> radiance;
            if (begin < end) {
                HF_TRY(radiance, loop.shaded(begin, end));
            }
            for (std::size_t k = 0; k < share.count; ++k) {
                const auto [first, last] = share.range_of(k, loop.points);
                share.made[k].push_back(
                    {name, bytes_of<Outgoing>(std::span(radiance).subspan(first - begin, last - first))});
            }
            return Done{};
        }
        for (std::size_t part = 0; part < share.parts; ++part) {
            const auto [begin, end] = items_of_parts(loop.points, part, 1, share.parts);
            if (begin == end) continue;
            std::vector<Outgoing> radiance(end - begin);
            if (share.joined[part].empty()) {
                HF_TRY(radiance, loop.shaded(begin, end));
            } else if (!take_values<Outgoing>(share.joined[part], name, radiance)) {
                return wrong_part(part, name);
            }
            loop.take(begin, radiance);
        }
        return Done{};
    };
    return {run, share.joins};
}

std::size_t most_reference_parts(int height) {
    return 2 * static_cast<std::size_t>((height + strip_unit - 1) / strip_unit);
}

Result<ReferencePicture> shared_reference(const ReferenceFiles& scene, const PovrayOptions& options,
                                          const Progress& progress, TaskShare& share) {
    if (!share.joins) return rendered_strips(scene, options, progress, share);
    std::array<RenderedScene, 2> halves;
    const auto pixels = static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    for (RenderedScene& half : halves) {
        half.image.width = options.width;
        half.image.height = options.height;
        half.image.pixels.resize(pixels);
        half.image.coverage.resize(pixels);
    }
    for (std::size_t part = 0; part < share.parts; ++part) {
        const Strip strip = strip_of(part, share.parts, options.height);
        Image& image = halves[strip.set].image;
        if (!take_values(share.joined[part], "pixels", rows_of(image, strip)) ||
            !take_values(share.joined[part], "coverage", coverage_rows_of(image, strip)))
            return wrong_part(part, "pixels");
    }
    return reference_of_halves(scene, std::move(halves));
}

}  // namespace haarfield
