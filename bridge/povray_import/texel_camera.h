#pragma once
/// Pictures whose pixels are points of surfaces. Internal.

#include "bridge/povray_import/scene_queries.h"

namespace haarfield {

/// Returns the text of a colour that no pigment has, for what lies behind surfaces.
std::string no_surface_colour();

/// Tests for each pixel whether it shows something else than no_surface_colour.
///
/// pixels  linear, of a query with in_numbers = false.
std::vector<std::uint8_t> pixels_on_surfaces(const SceneGamma& gamma, std::span<const Rgb> pixels);

/// The text of POV-Ray's camera that renders each point of a mesh at its place in a picture: a mesh_camera
/// with distribution 3.
class TexelCamera {
public:
    /// Makes the camera of a picture of this size. [pixels]
    TexelCamera(int width, int height) : width_(width), height_(height) {}

    /// Adds a vertex.
    ///
    /// u, v  place in the picture, from (0, 0) at the lower left corner to (1, 1).
    void add_vertex(const Vec3d& position, double u, double v);
    /// Adds a triangle whose corners are in counter-clockwise order where its rays come from.
    void add_triangle(std::size_t a, std::size_t b, std::size_t c);
    std::size_t vertices() const { return vertices_; }  ///< Number of those added.

    /// Returns the camera and a background of no_surface_colour.
    ///
    /// start  distance of the rays' starts from the mesh.
    std::string text(double start) const;

private:
    int width_, height_;
    std::size_t vertices_ = 0, triangles_ = 0;
    std::string positions_, uvs_, faces_;
};

}  // namespace haarfield
