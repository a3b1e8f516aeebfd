#pragma once
/// Writes an error budget as one self-contained page, budget.html.

#include "bridge/pictures/oracle_check.h"
#include "shading/bake/error_budget.h"

namespace haarfield {

/// The contents of the page. Pointers must outlive the call.
struct BudgetReport {
    /// A place in the preview where a vertex errs.
    struct Mark {
        double x = 0, y = 0;  ///< [pixels], from the upper left corner.
        double relative_error = 0;
    };

    std::string title;  ///< For example the scene's name.
    std::span<const BudgetEntry> entries;
    std::size_t vertices = 0;        ///< The number of measured vertices.
    const Image* preview = nullptr;  ///< A picture of the bake.
    std::vector<Mark> worst;         ///< The worst vertices that are visible in the preview.
    std::optional<OracleCheck> oracle;
    std::vector<std::string> commands;
};

/// Writes the page as one HTML file: a plot and a table of the approximations, the worst vertices marked on
/// the preview, and the agreement of the oracle with POV-Ray.
///
/// errors  those of write_file.
Result<Done> write_budget_report(const BudgetReport& report, const std::filesystem::path& file);

}  // namespace haarfield
