#pragma once
/// Warnings about model files: each finding once per file, with the names of the parts concerned.

#include "fields/model/model_file.h"

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace haarfield {

/// Collects findings about the parts of model files.
class ModelWarnings {
public:
    /// Adds the findings of a mesh. A second call for the same part has no effect.
    ///
    /// part  name of the part; empty: the whole file.
    void add_findings(const std::filesystem::path& file, const std::string& part,
                      const MeshFindings& findings);
    /// Adds properties of materials that haarfield does not use.
    void add_unused(const std::filesystem::path& file, const UnusedProperties& unused);
    /// Adds an image that was found neither in the file's directory nor below.
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
        std::vector<std::string> parts;  ///< Parts with findings, in the order in which they were added.
        std::set<std::string> added;     ///< All parts added.
        UnusedProperties unused;
        std::vector<std::string> missing_images, unmapped_images;
        bool left_handed = false;
    };
    Findings& of(const std::filesystem::path& file);

    std::vector<std::pair<std::filesystem::path, Findings>> files_;
};

}  // namespace haarfield
