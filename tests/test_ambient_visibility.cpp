#include "fields/field/ambient_visibility.h"

#include <gtest/gtest.h>

#include "fields/field/field_precompute.h"
#include "fields/wavelets/haar_transform.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/unpacked_face.h"

namespace haarfield {
namespace {

TEST(AmbientVisibility, MeanOverDirectionsIsTheSumOfTexelsTimesSolidAngles) {
    for (const VisibilityField& field : {example_field(), random_field(3, 0)}) {
        const int size = field.pool.face_size;
        const std::vector<DirectionMeans> means = mean_over_directions(field.pool);
        ASSERT_EQ(means.size(), field.pool.cubemaps.size());
        for (std::size_t handle = 0; handle < means.size(); handle += 1 + means.size() / 50) {
            double sum = 0;
            Vec3d directions(0.0);
            for (int f = 0; f < cubemap_faces; ++f) {
                const std::uint32_t face = field.pool.cubemaps[handle][std::size_t(f)];
                const std::vector<float> texels = quadtree_texels(unpacked_face(field.pool, face), size);
                for (int i = 0; i < size * size; ++i) {
                    const double open =
                        double(texels[std::size_t(i)]) * texel_solid_angle(i % size, i / size, size);
                    sum += open;
                    directions += Vec3d(texel_direction(f, i % size, i / size, size)) * open;
                }
            }
            EXPECT_NEAR(means[handle].visibility, sum / (4 * pi), 1e-6) << "handle " << handle;
            EXPECT_TRUE(Vec3d(means[handle].direction).equalWithAbsError(directions / (4 * pi), 1e-6))
                << "handle " << handle << ": " << means[handle].direction;
        }
    }
}

TEST(AmbientVisibility, OfASphereIsOneMinusItsCone) {
    const float radius = 0.5f;
    const Vec3f centre(1, 2, 3);
    const PreparedMesh mesh = prepared_as_is(sphere_mesh(centre, radius, 16));
    const VisibilityField field =
        *precompute_field("sphere", mesh, EntityOcclusion(mesh), {32, 0, 0, 6, 4000});
    const AmbientVisibility volume = ambient_visibility(field);
    ASSERT_EQ(volume.size, (std::array<std::int32_t, 3>{41, 41, 41}));
    ASSERT_EQ(volume.values.size(), 41u * 41 * 41);
    const Vec3f margin(0.5f * field.bounds.radius());
    EXPECT_TRUE(volume.origin.equalWithAbsError(field.bounds.lower - margin, 1e-5f)) << volume.origin;
    EXPECT_TRUE((volume.origin + Vec3f(40 * volume.voxel_size))
                    .equalWithAbsError(field.bounds.upper + margin, 1e-5f));
    std::size_t i = 0;
    int outside = 0;
    for (int x = 0; x <= 40; ++x)
        for (int y = 0; y <= 40; ++y)
            for (int z = 0; z <= 40; ++z, ++i) {
                const Vec3f place = volume.origin + Vec3f(float(x), float(y), float(z)) * volume.voxel_size;
                const double distance = (place - centre).length();
                // Closer to the surface, a cell of the sampler has corners inside and outside of the sphere.
                if (distance > 1.6 * radius) {
                    const double sine = radius / distance;
                    const double cosine = std::sqrt(1 - sine * sine);
                    EXPECT_NEAR(volume.values[i], (1 + cosine) / 2, 0.03) << x << " " << y << " " << z;
                    // The occluded cone contributes sine^2 / 4 along its axis to the mean over all
                    // directions.
                    const Vec3d away = Vec3d(place - centre) / distance * (sine * sine / (2 * (1 + cosine)));
                    EXPECT_TRUE(Vec3d(volume.directions[i]).equalWithAbsError(away, 0.03))
                        << x << " " << y << " " << z << ": " << volume.directions[i] << ", not " << away;
                    ++outside;
                } else if (distance < 0.6 * radius) {
                    EXPECT_EQ(volume.values[i], 0.0f) << x << " " << y << " " << z;
                    EXPECT_EQ(volume.directions[i], Vec3f(0.0f)) << x << " " << y << " " << z;
                }
            }
    EXPECT_GT(outside, 5000);
}

}  // namespace
}  // namespace haarfield
