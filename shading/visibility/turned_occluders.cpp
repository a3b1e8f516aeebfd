#include "shading/visibility/turned_occluders.h"

#include <map>
#include <tuple>

#include "fields/base/parallel_loop.h"

namespace haarfield {

TurnedOccluders::TurnedOccluders(const EntityOcclusion& occlusion, const Rotation& rotation)
    : coarse_(&occlusion.coarse()), own_(&occlusion.own()) {
    if (is_identity(rotation)) return;
    const bool is_one = own_ == coarse_;
    turned_coarse_ = std::make_unique<const Occluder>(turned_occluder(*coarse_, rotation));
    if (!is_one) turned_own_ = std::make_unique<const Occluder>(turned_occluder(*own_, rotation));
    coarse_ = turned_coarse_.get();
    own_ = is_one ? coarse_ : turned_own_.get();
}

bool InstanceOccluders::Key::operator<(const Key& other) const {
    const auto numbers = [](const Key& key) {
        const auto& [x, y, z] = key.rotation.row;
        return std::tuple(key.occlusion, x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z);
    };
    return numbers(*this) < numbers(other);
}

Result<InstanceOccluders> InstanceOccluders::make(const ShadedScene& scene, const InstanceOccluders* before,
                                                  const std::stop_token& stop) {
    std::map<Key, std::shared_ptr<const TurnedOccluders>> known;
    if (before)
        for (std::size_t i = 0; i < before->keys_.size(); ++i)
            known.emplace(before->keys_[i], before->occluders_[i]);
    InstanceOccluders result;
    std::vector<std::pair<const Key, std::shared_ptr<const TurnedOccluders>>*> missing;
    for (const ShadedInstance& instance : scene.instances) {
        result.keys_.push_back({scene.entities[instance.entity].occlusion, instance.placement.rotate});
        const auto [entry, is_new] = known.emplace(result.keys_.back(), nullptr);
        if (is_new) missing.push_back(&*entry);
    }
    HF_TRY_DONE(parallel_loop({missing.size()},
                              [&]() -> LoopBody {
                                  return [&](std::size_t k) {
                                      const Key& key = missing[k]->first;
                                      missing[k]->second = std::make_shared<const TurnedOccluders>(
                                          *key.occlusion, key.rotation);
                                  };
                              },
                              "turned occluders", {{}, stop}));
    for (const Key& key : result.keys_) result.occluders_.push_back(known.at(key));
    return result;
}

}  // namespace haarfield
