#include "tools/view/view_job.h"

namespace haarfield {

bool job_ends_for(const ViewJob& job, const Content& message, const std::optional<Vec3f>& eye) {
    using What = ViewJob::For;
    using Of = Variation::Of;
    if (job.what == What::nothing || job.what == What::frame) return false;
    const auto ends_for = [&](const Variation& variation) {
        const bool is_vectors = job.what == What::vectors || job.what == What::likely;
        return !is_vectors || job.variation != variation;
    };
    if (std::holds_alternative<TurnLight>(message) || std::holds_alternative<NamedLights>(message) ||
        std::holds_alternative<MixLights>(message) || std::holds_alternative<SetSky>(message))
        return ends_for({Of::light, 0});
    if (const auto* look = std::get_if<SetView>(&message))
        return eye && !is_same_place(look->camera.position, *eye, look->camera) && ends_for({Of::eye, 0});
    if (const auto* place = std::get_if<PartialPlace>(&message)) {
        if (!place->rotate) return ends_for({Of::object, place->object});
        return job.what != What::shade;  // rotating objects are shaded in full as often as possible
    }
    if (std::holds_alternative<SetExposure>(message))
        return job.what == What::commit || job.what == What::likely;
    if (std::holds_alternative<SetMaterial>(message) || std::holds_alternative<SetLamp>(message))
        return job.what != What::shade && job.what != What::recommit;
    return std::holds_alternative<CloneObject>(message) || std::holds_alternative<DeleteObject>(message) ||
           std::holds_alternative<Restore>(message) || std::holds_alternative<EditPartMaterial>(message) ||
           std::holds_alternative<StepBack>(message) || std::holds_alternative<StepOn>(message);
}

bool is_same_place(const Vec3f& one, const Vec3f& other, const Camera& camera) {
    constexpr float rounding = 1e-5f;
    return (one - other).length() <= rounding * (camera.target - camera.position).length();
}

}  // namespace haarfield
