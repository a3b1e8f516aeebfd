#include "fields/model/obj_listing.h"

#include "fields/mesh/mesh.h"
#include "fields/model/text_words.h"

#include <assimp/fast_atof.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>
#include <span>
#include <unordered_map>

namespace haarfield {
namespace {

/// Removes the next line from a text, joined with the following ones if it ends in a backslash.
std::string joined_line(std::string_view& text) {
    std::string line;
    bool goes_on = true;
    while (goes_on && !text.empty()) {
        std::string_view part = next_line(text);
        goes_on = part.ends_with('\\');
        if (goes_on) part.remove_suffix(1);
        line += part;
        if (goes_on) line += ' ';
    }
    return line;
}

/// The exception type of assimp's template, because assimp does not export its own.
struct NotANumber {
    explicit NotANumber(const auto&...) {}
};

/// Converts a word with assimp's rounding; NaN if assimp rejects it.
float number(const std::string& word) {
    try {
        return Assimp::fast_atof<NotANumber>(word.c_str());
    } catch (const NotANumber&) {
        return std::numeric_limits<float>::quiet_NaN();
    }
}

/// Adds a vertex from x y z, optionally followed by a weight or a colour. Ignores other lines.
void add_vertex(std::string_view line, ContentListing& listing) {
    std::vector<float> numbers;
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line))
        numbers.push_back(number(std::string(word)));
    if (numbers.size() != 3 && numbers.size() != 4 && numbers.size() != 6) return;
    const float weight = numbers.size() == 4 ? numbers[3] : 1;
    listing.positions.emplace_back(numbers[0] / weight, numbers[1] / weight, numbers[2] / weight);
}

/// Adds a face. Corners are numbers from 1, or from -1 backwards, possibly followed by slashes and other
/// numbers.
void add_face(std::string_view line, ContentListing& listing) {
    const auto vertices = static_cast<std::int64_t>(listing.positions.size());
    const std::size_t before = listing.corners.size();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        std::int64_t vertex = 0;
        std::from_chars(word.data(), word.data() + word.size(), vertex);
        vertex = vertex < 0 ? vertices + vertex : vertex - 1;
        if (!(vertex >= 0 && vertex < vertices)) {
            listing.corners.resize(before);
            return;
        }
        listing.corners.push_back(static_cast<std::uint32_t>(vertex));
    }
    listing.face_corners.push_back(static_cast<std::uint32_t>(listing.corners.size() - before));
}

/// Returns a hash of the positions of corners.
std::uint64_t face_key(const std::vector<Vec3f>& positions, std::span<const std::uint32_t> corners) {
    std::uint64_t hash = corners.size();
    for (const std::uint32_t corner : corners)
        for (int axis = 0; axis < 3; ++axis) {
            hash = (hash ^ std::bit_cast<std::uint32_t>(positions[corner][axis])) * 0x9e3779b97f4a7c15u;
            hash ^= hash >> 29;
        }
    return hash;
}

/// The faces of a listing, each of which can be used once.
class ListedFaces {
public:
    explicit ListedFaces(const ContentListing& listing) : listing_(listing) {
        std::uint32_t first = 0;
        for (std::uint32_t face = 0; face < listing.face_corners.size(); ++face) {
            first_.push_back(first);
            by_key_.emplace_back(face_key(listing.positions, corners(face)), face);
            first += listing.face_corners[face];
        }
        std::ranges::sort(by_key_);
        for (std::size_t i = by_key_.size(); i-- > 0;) next_[by_key_[i].first] = i;
    }

    std::span<const std::uint32_t> corners(std::uint32_t face) const {
        return std::span(listing_.corners).subspan(first_[face], listing_.face_corners[face]);
    }

    /// Returns the first unused face with corners at these positions, if there is one.
    std::optional<std::uint32_t> take(const std::vector<Vec3f>& positions,
                                      std::span<const std::uint32_t> at) {
        const std::uint64_t key = face_key(positions, at);
        const auto next = next_.find(key);
        if (next == next_.end() || next->second == by_key_.size() || by_key_[next->second].first != key)
            return std::nullopt;
        const std::uint32_t face = by_key_[next->second].second;
        const bool is_same = std::ranges::equal(corners(face), at, [&](std::uint32_t own, std::uint32_t its) {
            return listing_.positions[own] == positions[its];
        });
        if (!is_same) return std::nullopt;  // hash collision
        ++next->second;
        return face;
    }

private:
    const ContentListing& listing_;
    std::vector<std::uint32_t> first_;                             // first corner, by face
    std::vector<std::pair<std::uint64_t, std::uint32_t>> by_key_;  // sorted
    std::unordered_map<std::uint64_t, std::size_t> next_;          // index in by_key_
};

}  // namespace

ContentListing obj_listing(std::string_view text) {
    ContentListing listing;
    while (!text.empty()) {
        const std::string line = joined_line(text);
        if (line.starts_with("v ") || line.starts_with("v\t"))
            add_vertex(std::string_view(line).substr(1), listing);
        else if (line.starts_with("f"))
            add_face(std::string_view(line).substr(1), listing);
    }
    return listing;
}

void number_obj_vertices(const ContentListing& listing, std::vector<ContentMesh>& meshes) {
    ListedFaces faces(listing);
    for (ContentMesh& mesh : meshes) {
        mesh.numbers.assign(mesh.positions.size(), not_original);
        std::span<const std::uint32_t> corners = mesh.corners;
        const std::size_t count = mesh.face_corners.empty() ? corners.size() / 3 : mesh.face_corners.size();
        for (std::size_t f = 0; f < count; ++f) {
            const std::size_t own = mesh.face_corners.empty() ? 3 : mesh.face_corners[f];
            const std::span<const std::uint32_t> face = corners.first(own);
            corners = corners.subspan(own);
            if (std::ranges::any_of(face, [&](std::uint32_t c) { return c >= mesh.positions.size(); }))
                continue;
            const std::optional<std::uint32_t> known = faces.take(mesh.positions, face);
            if (!known) continue;
            mesh.faces.push_back(*known);
            const std::span<const std::uint32_t> listed = faces.corners(*known);
            for (std::size_t k = 0; k < own; ++k)
                mesh.numbers[face[k]] = static_cast<std::int32_t>(listed[k]);
        }
    }
}

}  // namespace haarfield
