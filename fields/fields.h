#pragma once
/// haarfield::fields: visibility fields of meshes, as Haar wavelets. This header is the manual of the
/// library, and includes the headers that users start with.
///
/// Purpose
///
/// A visibility field stores which directions a mesh blocks, from thousands of points around the mesh and
/// from every vertex of its surface. Each sample is a cubemap: 1 where a direction is unoccluded, 0 where the
/// mesh blocks it. The library rasterizes the cubemaps on the processor and tests eight directions per texel.
/// It transforms each cubemap into six quadtrees of Haar wavelets and drops small coefficients. The
/// visibility at any other point is interpolated. A field is stored as the grids of an OpenVDB file. It
/// depends on the mesh, including holes that the alpha of images cuts, but not on lighting, colours or
/// placement.
///
/// Data flow
///
///     file --read_mesh--> ImportedMesh --prepare_mesh--> PreparedMesh: fine mesh, coarse occluder
///     PreparedMesh --> EntityOcclusion: occluders, and the sample points of the vertices
///     PreparedMesh, EntityOcclusion --precompute_field--> VisibilityField
///     VisibilityField --write_field--> file --read_field--> VisibilityField
///     VisibilityField, weights of samples at a point --interpolated_visibility--> CubemapTree
///
/// or a single cubemap:
///
///     mesh --make_occluder--> Occluder --VisibilityRasterizer--> unoccluded samples per texel
///     texels --haar_cubemap--> CubemapTree
///
/// Where to start
///
/// | declaration | header | purpose |
/// |---|---|---|
/// | read_mesh | fields/model/mesh_reader.h | reads model files |
/// | prepare_mesh, PreparedMesh | fields/preparation/mesh_preparation.h | repairs, subdivides, simplifies |
/// | EntityOcclusion | fields/field/entity_occlusion.h | occluders of one entity |
/// | precompute_field | fields/field/field_precompute.h | computes a field |
/// | VisibilityField, interpolated_visibility | fields/field/visibility_field.h | a field and its lookup |
/// | write_field, read_field | fields/field/field_file.h | field files |
/// | library_field, library_entries | fields/field/field_library.h | folders of fields |
/// | make_occluder | fields/occluder/occluder.h | a mesh that blocks light |
/// | VisibilityRasterizer | fields/rasterizer/visibility_rasterizer.h | visibility at a point |
/// | CubemapTree, BasicQuadtree | fields/wavelets/quadtree.h | wavelets and their normalisation |
/// | haar_cubemap, Truncation | fields/wavelets/haar_transform.h | texels to wavelets |
///
/// Lengths are in metres. The frame is right-handed with y up (fields/base/vector.h).
/// fields/wavelets/cubemap.h defines faces, texels and directions. Long-running functions accept a Progress
/// (fields/base/progress.h) and run in parallel on oneTBB. Results do not depend on the number of threads.
/// Functions with untrusted input return a Result (fields/base/result.h); a violated precondition is an
/// assert. The library prints nothing.
///
/// A complete program: the visibility at a point next to a chair. The argument is a mesh file, such as the
/// installed scenes/meshes/chair.obj. Link with haarfield::fields.
///
/// ```cpp
/// #include "fields/fields.h"
///
/// #include <cstdio>
///
/// using namespace haarfield;
///
/// int main(int, char** arguments) {
///     Result<ImportedMesh> file = read_mesh(arguments[1]);
///     if (!file) return std::puts(file.error().message().c_str()), 1;
///     const Result<PreparedMesh> mesh =
///         prepare_mesh(std::move(*file), {.fine_vertices = 4000, .coarse_triangles = 2000});
///     if (!mesh) return std::puts(mesh.error().message().c_str()), 1;
///
///     // A few hundred samples for a quick result; the default is thirty thousand.
///     FieldSettings settings;
///     settings.planar_samples = 600;
///     settings.spherical_samples = 300;
///     const EntityOcclusion occlusion(*mesh);
///     const Result<VisibilityField> made = precompute_field("chair", *mesh, occlusion, settings);
///     if (!made) return std::puts(made.error().message().c_str()), 1;
///     if (const Result<Done> written = write_field(*made, "chair.vdb"); !written)
///         return std::puts(written.error().message().c_str()), 1;
///     const Result<VisibilityField> field = read_field("chair.vdb");
///     if (!field) return std::puts(field.error().message().c_str()), 1;
///
///     const Vec3f place = field->planar.centre + Vec3f(field->bounds.radius(), 0, 0);
///     const CubemapTree visibility = interpolated_visibility(*field, field->planar_handles,
///                                                            field->planar.interpolation(place));
///     for (const Quadtree& face : visibility.faces)
///         std::printf("open %.3f, %zu nodes\n", double(face.scaling), face.nodes.size());
///     // The chair is in direction -x, face 1; nothing is in direction +x, face 0.
///     return visibility.faces[1].scaling < 0.95f && visibility.faces[0].scaling == 1 ? 0 : 1;
/// }
/// ```

#include "fields/field/field_file.h"
#include "fields/field/field_library.h"
#include "fields/field/field_precompute.h"
#include "fields/model/mesh_reader.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/rasterizer/visibility_transform.h"
#include "fields/wavelets/haar_transform.h"
