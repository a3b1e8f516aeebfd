#pragma once
/// A relighting session that separates specular radiance from the light that textures multiply.

#include "bridge/pictures/preview.h"
#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"

#include <functional>

namespace haarfield {

/// The surfaces of each entity of a scene.
std::vector<std::vector<Surface>> surfaces_of(const SceneEntities& entities);

/// Two relighting sessions: one with all materials, and one without the specular lobes of textured surfaces
/// (Surface::has_separate_specular). The specular radiance is their difference. The second session exists
/// only if the scene has such surfaces, and doubles the time of all calls.
class TexturedSession {
public:
    /// surfaces  by entity and material.
    TexturedSession(ShadedScene scene, std::span<const std::vector<Surface>> surfaces,
                    const RenderSettings& settings, const TransferSettings& transfer = {});

    /// Calls a member function of RelightSession, with all of its arguments, for both sessions:
    /// `both(&RelightSession::set_eye, eye)`. Returns the result of the first session. If it is an error,
    /// the second session is not called.
    template <class Function, class... Arguments>
    std::invoke_result_t<Function, RelightSession&, const Arguments&...> both(Function function,
                                                                              const Arguments&... arguments) {
        using Value = std::invoke_result_t<Function, RelightSession&, const Arguments&...>;
        if constexpr (std::is_same_v<Value, Result<Done>>) {
            HF_TRY_DONE(std::invoke(function, all_, arguments...));
            return matte_ ? std::invoke(function, *matte_, arguments...) : Done{};
        } else {
            if (matte_) std::invoke(function, *matte_, arguments...);
            return std::invoke(function, all_, arguments...);
        }
    }

    /// @name As in RelightSession.
    /// @{
    const SceneColours& radiance() const { return all_.radiance(); }
    const ShadedScene& scene() const { return all_.scene(); }
    const Vec3f& eye() const { return all_.eye(); }
    const std::vector<ShadedInstance>& instances() const { return all_.instances(); }
    bool has_vectors() const { return all_.has_vectors(); }
    bool lacks_reflections() const { return all_.lacks_reflections(); }
    /// @}

    /// Memory of both sessions' transfer vectors. [bytes]
    std::size_t transfer_bytes() const {
        return all_.transfer_bytes() + (matte_ ? matte_->transfer_bytes() : 0);
    }

    /// Replaces the materials of all entities. Returns false and does nothing if the new materials need the
    /// second session and it does not exist, or the reverse.
    bool set_materials(std::span<const std::vector<Surface>> surfaces);

    /// Measures the error of the radiance over the pixels of a picture; see RelightSession::error.
    ///
    /// entities  those of the scene.
    /// errors    interrupted.
    Result<BakeError> error(const SceneEntities& entities, const Camera& camera, Preview& preview,
                            const Progress& progress = {});

    /// Returns the radiance of an instance. The specular component is zero where no texture needs it.
    std::vector<Outgoing> outgoing(std::size_t instance) const;

private:
    RelightSession all_;
    std::optional<RelightSession> matte_;
};

}  // namespace haarfield
