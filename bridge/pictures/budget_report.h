#pragma once
/// One page that shows an error budget: budget.html, complete in itself.

#include "bridge/pictures/oracle_check.h"
#include "shading/bake/error_budget.h"

namespace haarfield {

/// What the page shows. Pointers must outlive the call.
struct BudgetReport {
    /// A place in the preview where a vertex errs.
    struct Mark {
        double x = 0, y = 0;  ///< [pixels], from the upper left corner.
        double relative_error = 0;
    };

    std::string title;  ///< Such as the scene's name.
    std::span<const BudgetEntry> entries;
    std::size_t vertices = 0;        ///< That were measured.
    const Image* preview = nullptr;  ///< Of the bake.
    std::vector<Mark> worst;         ///< The worst vertices that can be seen in it.
    std::optional<OracleCheck> oracle;
    std::vector<std::string> commands;
};

/// Writes the page as one HTML file: a plot and a table of the approximations, the worst vertices on the
/// preview, and whether the oracle agrees with POV-Ray.
///
/// errors  what write_file says.
Result<Done> write_budget_report(const BudgetReport& report, const std::filesystem::path& file);

}  // namespace haarfield
