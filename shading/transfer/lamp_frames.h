#pragma once
/// What lamps and glowing surfaces add to the frames of a session, kept lamp by lamp.

#include "shading/bake/renderer.h"

namespace haarfield {

/// The radiance that each of a scene's lamps gives its vertices, as if it were white: a lamp that is dimmed,
/// coloured or switched costs nothing but the sum, and one that moves its own rays.
class LampFrames {
public:
    /// Makes what is missing for a scene's lamps, emitters and eye; the geometry is placed as the scene is.
    ///
    /// cost    60 to 120 ns a vertex for each lamp (and place of its area) that has changed more than its
    ///         colour; of all after forget() and for another eye. On all of oneTBB's threads.
    /// errors  interrupted; then all is as it was.
    /// wants_diffuse  diffuse_rows() will be asked for: twice the memory.
    ///
    /// returns  whether their light is another than it was.
    Result<bool> update(const ShadedScene& scene, const ShadingGeometry& geometry, bool wants_diffuse,
                        const Progress& progress);

    /// Nothing of what was kept holds any more: an instance has moved.
    void forget();

    /// Adds all of the lamps' light, with their colours, to the radiance of vertices.
    ///
    /// vertices  which; null: all.
    /// cost      1 ns a vertex and lamp.
    void add_to(SceneRadiance& radiance, const VertexMask* vertices) const;

    /// Whether there is any light of lamps and emitters.
    bool is_dark() const;

    /// The diffuse part of all of the lamps' light, with their colours; update() was told that it is wanted.
    SceneRadiance diffuse(const ShadedScene& scene) const;

    std::size_t bytes() const;  ///< Memory: 12 a vertex and lamp.

private:
    struct Kept {
        Lamp lamp;                                  ///< With its colour.
        std::shared_ptr<const RadianceParts> unit;  ///< Under it, if it were white; null: not needed yet.
    };
    /// Calls `act` with the radiance under each light, and the colour to multiply it with.
    template <class Act>
    void for_each_part(const Act& act) const;

    std::vector<Kept> lamps_;
    std::optional<RadianceParts> emitters_;
    Vec3f eye_{0, 0, 0};
};

}  // namespace haarfield
