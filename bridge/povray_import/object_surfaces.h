#pragma once
/// Meshes of a scene's objects with the colours and finishes that POV-Ray shows.

#include "bridge/povray_import/dual_contour.h"
#include "bridge/povray_import/scene_survey.h"
#include "scenes/image.h"
#include "shading/scene/material.h"

namespace haarfield {

/// An object to be sampled, and the grid around it.
struct GridRequest {
    std::size_t object = 0;  ///< Index in SceneSurvey::objects.
    Vec3d centre{0, 0, 0};   ///< Of the grid, in the scene's coordinates.
    Vec3d size{1, 1, 1};     ///< Of the grid, at least the object's box; all > 0.
    int cells = 64;          ///< Along the longest side.
    bool is_cut = false;     ///< The object continues outside the grid.
};

/// The surface of an object in the scene's coordinates.
struct ObjectSurface {
    std::size_t object = 0;
    std::vector<Vec3f> positions, normals;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Rgb> colours;  ///< The pigment at each vertex, linear; set by add_pigments.
    std::vector<Vec2f> uvs;    ///< Places in the image of pigment_image, which sets them; or none.
    float transmittance = 0;   ///< Mean fraction of light that passes the object; set by add_pigments.
    Rgb absorption{0.0f};      ///< Coefficient inside, per unit of the scene; set by add_pigments.
    Rgb filter{0.0f};          ///< Median fraction of light that passes each surface; set by add_pigments.
    std::size_t sheet_triangles = 0;  ///< As in ContouredMesh, with the counts of doubtful edges.
    std::size_t double_edges = 0, missed_edges = 0, lost_edges = 0;
};

/// Returns the places at which a ray crosses a surface, in multiples of its direction, unsorted.
///
/// from, direction  in the coordinates of the surface's positions.
/// cost             2 ns per triangle.
std::vector<double> surface_crossings(const ObjectSurface& surface, const Vec3d& from,
                                      const Vec3d& direction);

/// Surfaces of some objects, and those that POV-Ray did not finish.
struct ObjectSurfaces {
    std::vector<ObjectSurface> surfaces;  ///< Without empty ones, in the order of the requests.
    std::vector<std::size_t> slow;        ///< Indices of objects that took longer than their time limit.
    std::vector<Bounds> crossings;  ///< By request: the box of all crossings, in the scene's coordinates.
};

/// Returns the grid of an object whose crossings lie inside the grid of a request: their box, and two cells
/// on each side. None if there are no crossings, or some are in the outermost cells.
std::optional<GridRequest> own_grid(const GridRequest& request, const Bounds& crossings);

/// Samples surfaces: finds their crossings with the lines of a grid by POV-Ray's trace(), and contours them.
///
/// The cells are cubes, except that thin objects have at least eight cells in each direction. Surfaces that
/// are open, as `clipped_by` leaves them, become sheets.
///
/// requests        sorted by object, without duplicates.
/// object_seconds  limit of processor time for each object. [s] After an object exceeds it, POV-Ray parses
///                 the scene again.
/// errors          those of SceneQueries::answer.
/// cost            40 us of processor time per crossing of a union of six solids, most for parsing of the
///                 text; slow objects more.
Result<ObjectSurfaces> object_surfaces(const SceneQueries& queries, std::span<const GridRequest> requests,
                                       double object_seconds, const Progress& progress = {});

/// Measures the pigments at the vertices, as POV-Ray shows them without lights, and the transmittance.
///
/// accuracy  3e-5 for the pigment at a point, up to 4; a point within 0.1 cells of another surface of its
///           object may get that surface's pigment.
/// errors    those of SceneQueries::answer.
/// cost      two runs of POV-Ray, three if a surface is transparent, and 2 us per vertex.
/// source    a mesh_camera with one triangle for each ray.
Result<Done> add_pigments(const SceneQueries& queries, std::span<const GridRequest> requests,
                          std::vector<ObjectSurface>& surfaces, const Progress& progress = {});

/// Tests whether the pigment of a surface varies between its vertices. If few vertices have another
/// colour, those that do not share it with most of their neighbours are given the usual one: their
/// rays missed the surface beside a sharp edge.
bool find_pattern(ObjectSurface& surface);

/// Measures the pigments of surfaces at the texels of one image. Vertices at the borders of charts are
/// doubled.
///
/// A texel of a surface in the camera's picture appears about as large as 1/900 of the picture's width;
/// texels outside it are sixteen times larger. Without a camera, an object has 400 texels along its longest
/// side. The image has at most three million texels on surfaces; if more are wanted, all are larger.
///
/// chosen    indices of surfaces with colours; at least one.
/// opacity   measure coverage, too: the fraction of light that does not pass the surface. Otherwise the
///           surfaces must be opaque.
/// start     wall time of a run of POV-Ray that renders nothing. [s]
/// returns   linear colours >= 0, not multiplied by coverage; texels beside the surfaces repeat those at
///           their borders.
/// accuracy  as add_pigments, at the centres of texels.
/// errors    those of SceneQueries::answer.
/// cost      processor time: 3 us per texel, twice that with opacity; 0.3 ns for each texel and each
///           triangle, divided by the number of runs of POV-Ray, up to 32: the fewer, the longer `start` is.
/// source    a mesh_camera with distribution 3, which renders image coordinates.
Result<Image> pigment_image(const SceneQueries& queries, std::span<const GridRequest> requests,
                            std::vector<ObjectSurface>& surfaces, const std::vector<std::size_t>& chosen,
                            const std::optional<SurveyedCamera>& camera, bool opacity, double start,
                            const Progress& progress = {});

/// The finish of an object as far as haarfield has it.
struct MeasuredFinish {
    float diffuse = 0;                 ///< Factor of the pigment.
    float emission = 0;                ///< Factor of the pigment.
    float phong = 0, phong_size = 40;  ///< As POV-Ray's. At most one of phong and specular is not 0.
    float specular = 0, roughness = 0.05f;
    float reflection = 0;  ///< Of a uniform sky near normal incidence.
};

/// Measures finishes without light and under two coloured lights, from eleven viewing directions at up to 16
/// points per object.
///
/// ambient   the emission contains the scene's ambient light.
/// returns   a finish for each surface.
/// accuracy  1 % of diffuse; 2 % of the others.
/// errors    those of SceneQueries::answer.
/// cost      four runs of POV-Ray.
Result<std::vector<MeasuredFinish>> measured_finishes(const SceneQueries& queries,
                                                      std::span<const GridRequest> requests,
                                                      std::span<const ObjectSurface> surfaces, bool ambient,
                                                      const Progress& progress = {});

}  // namespace haarfield
