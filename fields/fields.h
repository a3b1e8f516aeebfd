#pragma once
/// haarfield::fields: from a mesh to what can be seen past it, as Haar wavelets. This header is the library's
/// manual, and includes what users start with.
///
/// What it does
///
/// An object is looked past from thousands of places round it and from every vertex of its own surface. Each
/// look is a cubemap of visibility, 1 where a direction is open and 0 where the object blocks it, rasterized
/// on the CPU with eight samples a texel, transformed into six quadtrees of Haar wavelets and truncated. All
/// of them together are the object's visibility field; it is interpolated between its samples, and kept in an
/// OpenVDB file that is sealed by checksums. Field and mesh do not depend on light, materials or place.
///
/// The way of the data
///
///     file --read_mesh--> ImportedMesh --prepare_mesh--> PreparedMesh: fine (baked), coarse (casts shadows)
///     PreparedMesh --> EntityOcclusion: occluders, where the vertices look from
///     both --precompute_field--> VisibilityField --write_field--> file --read_field--> VisibilityField
///     VisibilityField, a place --interpolated_visibility--> CubemapTree
///
/// or one look by itself:
///
///     mesh --make_occluder--> Occluder --VisibilityRasterizer--> counts of open samples
///     texels --haar_cubemap--> CubemapTree
///
/// Where to start
///
/// | declaration | is in |
/// |---|---|
/// | read_mesh | fields/mesh/mesh_reader.h |
/// | prepare_mesh, PreparedMesh | fields/mesh/mesh_preparation.h |
/// | EntityOcclusion | fields/field/entity_occlusion.h |
/// | precompute_field | fields/field/field_precompute.h |
/// | VisibilityField, interpolated_visibility | fields/field/visibility_field.h |
/// | write_field, read_field | fields/field/field_file.h |
/// | library_field, library_entries | fields/field/field_library.h |
/// | make_occluder | fields/mesh/occluder.h |
/// | VisibilityRasterizer | fields/rasterizer/visibility_rasterizer.h |
/// | CubemapTree, BasicQuadtree: the wavelets' convention | fields/wavelets/quadtree.h |
/// | haar_cubemap, Truncation | fields/wavelets/haar_transform.h |
///
/// Units are metres; the frame is right-handed with y up (fields/base/vector.h); faces, texels and directions
/// are those of fields/wavelets/cubemap.h. What may last takes a Progress (fields/base/progress.h) and uses
/// all of oneTBB's threads; their number changes no bit. Bad input is a value, Result (fields/base/result.h);
/// a caller's bug is an assert; nothing is printed.
///
/// A complete program: the visibility past a chair, a step away from it. Its argument is a mesh, such as the
/// installed scenes/meshes/chair.obj; linked with haarfield::fields.
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
///     // Some hundred samples for a quick look; the defaults are thirty thousand.
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
#include "fields/mesh/mesh_reader.h"
#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/rasterizer/visibility_transform.h"
#include "fields/wavelets/haar_transform.h"
