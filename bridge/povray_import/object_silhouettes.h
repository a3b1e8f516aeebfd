#pragma once
/// Finds where the meshes of objects differ from POV-Ray's objects. Internal.

#include "bridge/povray_import/object_surfaces.h"

namespace haarfield {

/// The silhouettes of objects along the axes, as POV-Ray shows them.
class ObjectSilhouettes {
public:
    /// Renders silhouettes with four pixels per cell of the objects' grids.
    ///
    /// requests  sorted by object. Objects that are cut have no silhouettes; if the pixels are too many,
    ///           neither have those with few cells.
    /// seconds   wall time after which POV-Ray is ended.
    /// errors    those of SceneQueries::answer.
    /// cost      one run of POV-Ray, and 2 us of processor time per pixel.
    /// source    texel_camera.h, with two triangles for each silhouette.
    static Result<ObjectSilhouettes> create(const SceneQueries& queries,
                                            std::span<const GridRequest> requests, double seconds,
                                            const Progress& progress = {});

    /// Returns the number of pixels at which an object's silhouettes and those of a surface differ by more
    /// than a quarter of a cell: thin parts that the surface lacks, and narrow gaps that it fills.
    ///
    /// returns  0 for objects without silhouettes.
    std::size_t wrong_pixels(const ObjectSurface& surface) const;

private:
    /// One silhouette: orthographic, along an axis of the scene.
    struct Tile {
        std::size_t object = 0;
        int axis = 0;                   ///< Of the rays. Columns follow the next axis, rows the one after.
        int columns = 0, rows = 0;      ///< [pixels]
        Vec3d lower{0, 0, 0};           ///< Of the pixels' box, in the scene.
        Vec3d pixels{1, 1, 1};          ///< Per unit of the scene, by axis.
        std::vector<std::uint8_t> met;  ///< 1: the pixel's ray meets the object.
    };

    void add_tiles(const GridRequest& request);

    std::vector<Tile> tiles_;  ///< Three for each object.
};

}  // namespace haarfield
