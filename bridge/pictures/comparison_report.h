#pragma once
/// Writes a comparison as one self-contained page, report.html.

#include "bridge/pictures/image_difference.h"

namespace haarfield {

/// The contents of the page. Pointers and their pixels must outlive the call.
struct ComparisonReport {
    std::string title;                 ///< For example the scene's name.
    std::string image_name = "baked";  ///< Labels under the pictures.
    std::string reference_name = "reference";
    const Image* image = nullptr;  ///< As compared: with premultiplied coverage.
    const Image* reference = nullptr;
    const ImageDifference* difference = nullptr;
    std::vector<std::pair<std::string, std::string>> facts;  ///< Further rows of the table: name, value.
    std::vector<std::string> commands;  ///< The command lines that made the pictures, in order.
};

/// Writes the report as one HTML file with embedded pictures, without external scripts or fonts, for light
/// and dark mode. A slider switches between the baked picture and the reference. Below follow the perceptual
/// error with its legend and histogram, the numbers and the command lines.
///
/// errors    those of write_file; pictures of different sizes or with non-finite radiance.
Result<Done> write_comparison_report(const ComparisonReport& report, const std::filesystem::path& file);

}  // namespace haarfield
