#pragma once
/// Radiance by lamps and emitters in the frames of a session, stored lamp by lamp.

#include "shading/bake/renderer.h"

namespace haarfield {

/// Caches the radiance of all vertices under each lamp with a white colour. Dimming, colouring or switching a
/// lamp then costs only the sum; moving it costs its own rays.
class LampFrames {
public:
    /// Computes the missing radiance for the lamps, emitters and eye of a scene. The instances of the
    /// geometry are placed as those of the scene.
    ///
    /// cost     60 to 120 ns per vertex for each lamp (and place of its area) of which more than the colour
    ///          has changed; for all lamps after forget() and for another eye. On all of oneTBB's threads.
    /// errors   interrupted; then nothing has changed.
    /// returns  whether the light of lamps and emitters has changed.
    Result<bool> update(const ShadedScene& scene, const ShadingGeometry& geometry, const Progress& progress);

    /// Discards all cached radiance. Call it after an instance has moved.
    void forget();

    /// Adds the light of all lamps, in their colours, to the radiance of vertices.
    ///
    /// diffuse   null, or the diffuse component of the radiance, to which theirs is added.
    /// vertices  the vertices to be updated; null: all.
    /// cost      1 ns per vertex and lamp.
    void add_to(SceneColours& radiance, SceneColours* diffuse, const VertexMask* vertices) const;

    /// Returns true if lamps and emitters emit no light.
    bool is_dark() const;

    /// Returns the diffuse radiance by all lamps, with their colours, and by emitters.
    SceneColours diffuse(const ShadedScene& scene) const;

    std::size_t bytes() const;  ///< Memory: 24 bytes per vertex and lamp. [bytes]

private:
    struct Kept {
        Lamp lamp;                                  ///< With its colour.
        std::shared_ptr<const SceneRadiance> unit;  ///< By the lamp in white; null: not needed yet.
    };
    /// Calls `act` with the radiance by each light, and the colour to multiply it with.
    template <class Act>
    void for_each_light(const Act& act) const;

    std::vector<Kept> lamps_;
    std::optional<SceneRadiance> emitters_;
    Vec3f eye_{0, 0, 0};
};

}  // namespace haarfield
