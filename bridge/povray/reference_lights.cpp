#include "bridge/povray/reference_lights.h"

#include <algorithm>

namespace haarfield {

Result<LightEstimate> lights_for_error(const std::filesystem::path& folder, const std::string& stem,
                                       const Camera& camera, std::span<const ReferenceInstance> instances,
                                       const Environment& environment, std::span<const Lamp> lamps,
                                       const PovrayOptions& options, double wanted,
                                       const Progress& progress) {
    constexpr std::array<int, 3> tried{64, 256, 1024};
    // The difference of two pictures is only a rough estimate of their error.
    constexpr double surely = 0.7;
    PovrayOptions small = options;
    small.width = std::max(1, options.width / 4);
    small.height = std::max(1, options.height / 4);
    small.antialiasing = 0;
    std::array<double, tried.size()> error{};
    for (std::size_t k = 0; k < tried.size(); ++k) {
        HF_TRY(const ReferenceFiles files,
               write_reference_scene(folder, stem, camera, instances, environment, tried[k], {}, lamps));
        HF_TRY(const ReferencePicture picture, rendered_reference(files, small, progress));
        error[k] = double(*picture.image.relative_error);
        if (error[k] <= surely * wanted) return LightEstimate{tried[k], error[k]};
    }
    return estimated_lights(tried[1], error[1], tried[2], error[2], wanted);
}

}  // namespace haarfield
