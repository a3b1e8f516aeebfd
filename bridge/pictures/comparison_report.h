#pragma once
/// One page that shows a comparison: report.html, complete in itself.

#include "bridge/pictures/image_difference.h"

namespace haarfield {

/// What the page shows. Pointers and their pixels must outlive the call.
struct ComparisonReport {
    std::string title;                 ///< Such as the scene's name.
    std::string image_name = "baked";  ///< Labels under the pictures.
    std::string reference_name = "reference";
    const Image* image = nullptr;  ///< As compared; premultiplied.
    const Image* reference = nullptr;
    const ImageDifference* difference = nullptr;
    std::vector<std::pair<std::string, std::string>> facts;  ///< Further rows of the table: name, value.
    std::vector<std::string> commands;  ///< Command lines that made the pictures, in order.
};

/// Writes the report as one HTML file: pictures embedded, no script or font from elsewhere, readable in
/// light and dark mode. Baked and reference lie on one another behind a slider, with the perceptual
/// error, its legend and histogram, the numbers and the command lines below.
///
/// errors    what write_file says; pictures of different sizes or with non-finite radiance.
Result<Done> write_comparison_report(const ComparisonReport& report, const std::filesystem::path& file);

}  // namespace haarfield
