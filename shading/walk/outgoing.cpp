#include "shading/walk/outgoing.h"

#include <algorithm>

namespace haarfield {
namespace {

template <class Value>
SceneColours values_of(const SceneRadiance& radiance, const Value& value) {
    SceneColours result;
    for (const std::vector<Outgoing>& vertices : radiance) {
        result.emplace_back().reserve(vertices.size());
        for (const Outgoing& vertex : vertices) result.back().push_back(value(vertex));
    }
    return result;
}

}  // namespace

Outgoing without_negative(const Outgoing& radiance) {
    Outgoing result;
    for (int c = 0; c < 3; ++c) {
        const float diffuse = radiance.diffuse[c], specular = radiance.specular[c];
        result.diffuse[c] = std::max(diffuse + std::min(specular, 0.0f), 0.0f);
        result.specular[c] = std::max(specular + std::min(diffuse, 0.0f), 0.0f);
    }
    return result;
}

SceneColours total(const SceneRadiance& radiance) {
    return values_of(radiance, [](const Outgoing& vertex) { return vertex.total(); });
}

SceneColours diffuse_component(const SceneRadiance& radiance) {
    return values_of(radiance, [](const Outgoing& vertex) { return vertex.diffuse; });
}

SceneColours specular_component(const SceneRadiance& radiance) {
    return values_of(radiance, [](const Outgoing& vertex) { return vertex.specular; });
}

}  // namespace haarfield
