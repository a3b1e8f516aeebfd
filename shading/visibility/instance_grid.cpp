#include "shading/visibility/instance_grid.h"

#include <algorithm>

namespace haarfield {

InstanceGrid::InstanceGrid(std::span<const Sphere> spheres, const Bounds& where) {
    for (const Sphere& sphere : spheres) bounds_.add(sphere.centre, sphere.radius);
    reached_ = bounds_;
    if (!spheres.empty())
        for (int axis = 0; axis < 3; ++axis) {
            bounds_.lower[axis] = std::clamp(where.lower[axis], bounds_.lower[axis], bounds_.upper[axis]);
            bounds_.upper[axis] = std::clamp(where.upper[axis], bounds_.lower[axis], bounds_.upper[axis]);
        }
    if (!spheres.empty()) {
        constexpr double cells_a_sphere = 64, numbers_a_sphere = 64;
        double wanted = std::min(cells_a_sphere * double(spheres.size()), double(1 << 18));
        set_cells(wanted);
        while (wanted > 1 && touched_cells(spheres) > numbers_a_sphere * double(spheres.size()))
            set_cells(wanted /= 2);
    }
    const auto for_each_cell = [&](const Sphere& sphere, const auto& act) {
        const Vec3f lower = sphere.centre - Vec3f(sphere.radius),
                    upper = sphere.centre + Vec3f(sphere.radius);
        for (int z = cell(lower.z, 2); z <= cell(upper.z, 2); ++z)
            for (int y = cell(lower.y, 1); y <= cell(upper.y, 1); ++y)
                for (int x = cell(lower.x, 0); x <= cell(upper.x, 0); ++x)
                    act(std::size_t((z * cells_[1] + y) * cells_[0] + x));
    };
    first_.assign(std::size_t(cells_[0]) * std::size_t(cells_[1]) * std::size_t(cells_[2]) + 1, 0);
    for (const Sphere& sphere : spheres) for_each_cell(sphere, [&](std::size_t c) { ++first_[c + 1]; });
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    sphere_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < spheres.size(); ++i)
        for_each_cell(spheres[i], [&](std::size_t c) { sphere_[next[c]++] = i; });
}

void InstanceGrid::set_cells(double wanted) {
    const Vec3d size(bounds_.upper - bounds_.lower);
    double side = std::max(std::cbrt(size.x * size.y * size.z / wanted), 1e-20), cells = 0;
    // A box that is thinner than a cell would get too many cells along its other axes.
    do {
        cells = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<std::size_t>(axis);
            cells_[k] = static_cast<int>(std::clamp(size[axis] / side, 1.0, wanted));
            cells *= cells_[k];
        }
        side *= 1.1;
    } while (cells > wanted);
    for (int axis = 0; axis < 3; ++axis)
        cells_per_metre_[axis] =
            size[axis] > 0 ? static_cast<float>(cells_[static_cast<std::size_t>(axis)] / size[axis]) : 0.0f;
}

double InstanceGrid::touched_cells(std::span<const Sphere> spheres) const {
    double sum = 0;
    for (const Sphere& sphere : spheres) {
        double product = 1;
        for (int axis = 0; axis < 3; ++axis)
            product *= 1 + cell(sphere.centre[axis] + sphere.radius, axis) -
                       cell(sphere.centre[axis] - sphere.radius, axis);
        sum += product;
    }
    return sum;
}

int InstanceGrid::cell(float coordinate, int axis) const {
    const float index = (coordinate - bounds_.lower[axis]) * cells_per_metre_[axis];
    const int last = cells_[static_cast<std::size_t>(axis)] - 1;
    return index > 0 ? static_cast<int>(std::min(index, float(last))) : 0;
}

std::span<const std::uint32_t> InstanceGrid::near(const Vec3f& point) const {
    for (int axis = 0; axis < 3; ++axis)
        if (!(point[axis] >= reached_.lower[axis] && point[axis] <= reached_.upper[axis])) return {};
    const auto c =
        std::size_t((cell(point.z, 2) * cells_[1] + cell(point.y, 1)) * cells_[0] + cell(point.x, 0));
    return {sphere_.data() + first_[c], sphere_.data() + first_[c + 1]};
}

}  // namespace haarfield
