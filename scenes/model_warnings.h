#pragma once
/// Warnings about model files: each finding once per file, with the names of what it concerns.

#include "fields/model/model_file.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace haarfield {

/// Gathers findings of the parts of model files.
class ModelWarnings {
public:
    /// Adds what was found in a mesh; a second time without effect.
    ///
    /// part  of the file; empty: all of it.
    void add_findings(const std::filesystem::path& file, const std::string& part,
                      const MeshFindings& findings);
    /// Adds properties of materials that are not used.
    void add_unused(const std::filesystem::path& file, const UnusedProperties& unused);
    /// Adds an image that is neither in the folder of the file nor below.
    void add_missing_image(const std::filesystem::path& file, const std::string& image);
    /// Adds an image whose material has no texture coordinates.
    void add_unmapped_image(const std::filesystem::path& file, const std::string& image);

    /// Adds a file of left-handed coordinates that an instance does not mirror.
    void add_left_handed(const std::filesystem::path& file);

    /// One line per file and kind of finding, files in the order in which they were added.
    std::vector<std::string> lines() const;

private:
    struct Findings {
        MeshFindings sum;
        std::vector<std::string> parts;  ///< With findings, in the order in which they were added.
        std::set<std::string> added;     ///< All parts that were added.
        UnusedProperties unused;
        std::vector<std::string> missing_images, unmapped_images;
        bool left_handed = false;
    };
    Findings& of(const std::filesystem::path& file);

    std::vector<std::pair<std::filesystem::path, Findings>> files_;
};

}  // namespace haarfield
