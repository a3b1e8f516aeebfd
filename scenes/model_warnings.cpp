#include "scenes/model_warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/base/names.h"

namespace haarfield {
namespace {

constexpr std::size_t most_listed = 3;

void add_once(std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
}

/// Adds all counts of findings.
void add_to(MeshFindings& sum, const MeshFindings& added) {
    for (std::uint64_t MeshFindings::*const count :
         {&MeshFindings::polygons, &MeshFindings::non_finite_vertices, &MeshFindings::duplicate_vertices,
          &MeshFindings::degenerate_triangles, &MeshFindings::duplicate_triangles,
          &MeshFindings::non_manifold_edges, &MeshFindings::boundary_edges, &MeshFindings::flipped_triangles,
          &MeshFindings::components, &MeshFindings::open_components, &MeshFindings::parted_vertices,
          &MeshFindings::backs})
        sum.*count += added.*count;
    sum.self_intersecting |= added.self_intersecting;
}

std::string unused_text(const UnusedProperties& unused) {
    std::string text;
    for (const auto& [property, materials] : unused)
        text += fmt::format(
            "{}{} of {} {}", text.empty() ? "" : ", ", property,
            materials.size() == 1 ? "material" : fmt::format("{} materials:", materials.size()),
            quoted_list(std::vector<std::string>(materials.begin(), materials.end()), most_listed));
    return text;
}

}  // namespace

ModelWarnings::Findings& ModelWarnings::of(const std::filesystem::path& file) {
    const auto found = std::ranges::find(files_, file, [](const auto& entry) { return entry.first; });
    if (found != files_.end()) return found->second;
    return files_.emplace_back(file, Findings()).second;
}

void ModelWarnings::add_findings(const std::filesystem::path& file, const std::string& part,
                                 const MeshFindings& findings) {
    Findings& known = of(file);
    if (!known.added.insert(part).second || findings.summary().empty()) return;
    add_to(known.sum, findings);
    if (!part.empty()) known.parts.push_back(part);
}

void ModelWarnings::add_unused(const std::filesystem::path& file, const UnusedProperties& unused) {
    Findings& known = of(file);
    for (const auto& [property, materials] : unused)
        known.unused[property].insert(materials.begin(), materials.end());
}

void ModelWarnings::add_missing_image(const std::filesystem::path& file, const std::string& image) {
    add_once(of(file).missing_images, image);
}

void ModelWarnings::add_unmapped_image(const std::filesystem::path& file, const std::string& image) {
    add_once(of(file).unmapped_images, image);
}

void ModelWarnings::add_left_handed(const std::filesystem::path& file) {
    of(file).left_handed = true;
}

std::vector<std::string> ModelWarnings::lines() const {
    std::vector<std::string> lines;
    for (const auto& [file, found] : files_) {
        const std::string where = file.string();
        if (found.left_handed)
            lines.push_back(fmt::format(
                "{}: coordinates are left-handed, as POV-Ray's camera shows them; haarfield's pictures show "
                "the "
                "mirror image unless the instances have scale = [1, 1, -1], or a matrix as import writes it",
                where));
        if (!found.missing_images.empty())
            lines.push_back(fmt::format("{}: image {} not found next to the file or below; left out", where,
                                        quoted_list(found.missing_images, most_listed)));
        if (!found.unmapped_images.empty())
            lines.push_back(fmt::format("{}: no texture coordinates for image {}; left out", where,
                                        quoted_list(found.unmapped_images, most_listed)));
        if (!found.unused.empty())
            lines.push_back(fmt::format("{}: not used: {}", where, unused_text(found.unused)));
        const std::string summary = found.sum.summary();
        if (summary.empty()) continue;
        const std::string parts =
            found.parts.empty()
                ? ""
                : fmt::format(" in {} {}",
                              found.parts.size() == 1 ? "part" : fmt::format("{} parts:", found.parts.size()),
                              quoted_list(found.parts, most_listed));
        lines.push_back(fmt::format("{}: {}{}", where, summary, parts));
    }
    return lines;
}

}  // namespace haarfield
