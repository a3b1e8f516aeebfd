#include "fields/mesh/turned_mesh.h"

#include "fields/base/rotation.h"

namespace haarfield {

PreparedMesh turned_mesh(PreparedMesh mesh, const Vec3f& angles) {
    if (angles == Vec3f(0.0f)) return mesh;
    const Rotation rotation = rotation_xyz(angles);
    for (Mesh* part : {&mesh.original, &mesh.backs, &mesh.fine, &mesh.coarse}) {
        for (Vec3f& position : part->positions) position = rotation(position);
        for (Vec3f& normal : part->normals) normal = rotation(normal).normalized();
    }
    return mesh;
}

}  // namespace haarfield
