#include "tools/farm/plan_costs.h"

#include <algorithm>
#include <set>
#include <system_error>

#include "scenes/bake_search.h"
#include "tools/number_option.h"

namespace haarfield {
namespace {

// Measured on one core of an AMD EPYC (Zen 4), rounded. [s]
constexpr double a_sample = 40e-6, a_vertex = 40e-6, a_vertex_by_fields = 12e-6, a_bounced_vertex = 20e-6,
                 a_dense_vertex = 2e-3, a_ray_sample = 0.3e-6, a_fitted_vertex = 150e-6,
                 a_transfer_vertex = 15e-6, a_frame_vertex = 0.2e-6, a_frame_pixel = 0.3e-6,
                 a_light_of_a_pixel = 0.15e-6, a_rendered_pixel = 30e-6, a_written_vertex = 1e-6,
                 a_mesh_byte = 50e-9, a_prepared_vertex = 4e-6, a_read_sample = 3e-6, at_least = 0.3,
                 a_direct_choice = 2;

// Measured on the table and chairs and on halls of them, rounded up. [bytes]
constexpr double program_bytes = 300e6, sample_bytes = 3e3, fine_vertex_bytes = 300, shaded_vertex_bytes = 24,
                 bounced_vertex_bytes = 300, transfer_vertex_bytes = 2e3, pixel_bytes = 200;

/// Returns the vertices of an entity's fine mesh. A large file has more than the scene requests.
double vertices_of(const Entity& entity) {
    constexpr double bytes_a_vertex = 100;
    std::error_code unknown;
    const auto bytes = std::filesystem::file_size(entity.mesh, unknown);
    return std::max(double(entity.fine_vertices), unknown ? 0.0 : double(bytes) / bytes_a_vertex);
}

/// Returns the entities that have instances.
std::set<std::size_t> entities_of(const Scene& scene) {
    std::set<std::size_t> entities;
    for (const Instance& instance : scene.instances) entities.insert(instance.entity);
    return entities;
}

double all_vertices(const Scene& scene) {
    double sum = 0;
    for (const Instance& instance : scene.instances) sum += vertices_of(scene.entities[instance.entity]);
    return sum;
}

/// Returns the number of samples of an entity's field.
double samples_of(const Entity& entity) {
    return vertices_of(entity) + entity.planar_samples + entity.spherical_samples;
}

/// Returns the time to start and to read the meshes, which every command spends.
double reading_of(const Scene& scene) {
    double reading = at_least;
    for (const std::size_t entity : entities_of(scene)) {
        std::error_code unknown;
        const auto bytes = std::filesystem::file_size(scene.entities[entity].mesh, unknown);
        if (!unknown) reading += a_mesh_byte * double(bytes);
    }
    return reading;
}

/// Returns the time before shading: reading and preparing meshes and their fields.
double setup_of(const Scene& scene) {
    double setup = reading_of(scene);
    for (const std::size_t entity : entities_of(scene))
        setup += a_prepared_vertex * vertices_of(scene.entities[entity]) +
                 a_read_sample * samples_of(scene.entities[entity]);
    return setup;
}

double pixels_of(const Scene& scene) {
    return double(scene.camera.width) * double(scene.camera.height);
}

/// Returns the memory of meshes and fields, which every task reads completely, plus vertex_bytes per vertex
/// of each instance.
double scene_bytes(const Scene& scene, double vertex_bytes) {
    double bytes = program_bytes + pixel_bytes * pixels_of(scene) + vertex_bytes * all_vertices(scene);
    for (const std::size_t entity : entities_of(scene))
        bytes += fine_vertex_bytes * vertices_of(scene.entities[entity]) +
                 sample_bytes * samples_of(scene.entities[entity]);
    return bytes;
}

/// Returns the time to refine the meshes of a bake.
double refinement_work(const std::vector<std::string>& arguments) {
    return 3 * a_vertex * option_number(arguments, "--vertex-budget", 60000);
}

}  // namespace

double option_number(const std::vector<std::string>& arguments, std::string_view name, double otherwise) {
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string& argument = arguments[i];
        std::string_view text;
        if (argument == name && i + 1 < arguments.size()) text = arguments[i + 1];
        if (argument.starts_with(std::string(name) + "="))
            text = std::string_view(argument).substr(name.size() + 1);
        if (const auto number = number_in({-1e30, 1e30}, text)) return *number;
    }
    return otherwise;
}

bool has_option(const std::vector<std::string>& arguments, std::string_view name) {
    return std::ranges::any_of(arguments, [&](const std::string& argument) {
        return argument == name || argument.starts_with(std::string(name) + "=");
    });
}

bool has_value(const std::vector<std::string>& arguments, std::string_view name, std::string_view value) {
    const std::string whole = std::string(name) + "=" + std::string(value);
    for (std::size_t i = 0; i < arguments.size(); ++i)
        if (arguments[i] == whole || (i > 0 && arguments[i - 1] == name && arguments[i] == value))
            return true;
    return false;
}

JobCost remainder_cost(const Scene& scene, const std::vector<std::string>& arguments) {
    const double bytes = scene_bytes(scene, bounced_vertex_bytes);
    if (!searches(arguments)) return {setup_of(scene), a_bounced_vertex * all_vertices(scene), bytes};
    return {setup_of(scene) + a_direct_choice,
            a_bounced_vertex * all_vertices(search_start(scene)) + refinement_work(arguments), bytes};
}

JobCost join_cost(const Scene& scene, const std::vector<std::string>& arguments) {
    const double pixels = has_option(arguments, "--no-render") ? 0 : pixels_of(scene);
    return {setup_of(scene), a_rendered_pixel * pixels + a_written_vertex * all_vertices(scene),
            scene_bytes(scene, bounced_vertex_bytes)};
}

JobCost field_cost(const Scene& scene, std::size_t instance) {
    const Entity& entity = scene.entities[scene.instances[instance].entity];
    Scene alone;
    alone.entities = {entity};
    alone.instances = {{"", 0, {}}};
    // The task that computes the last part also joins all parts.
    return {reading_of(alone) + a_prepared_vertex * vertices_of(entity), a_sample * samples_of(entity),
            scene_bytes(alone, 0)};
}

JobCost command_cost(const Scene& scene, const std::vector<std::string>& arguments) {
    const std::string& command = arguments.front();
    const double vertices = all_vertices(scene), pixels = pixels_of(scene);
    if (command == "bake") {
        const double each = has_value(arguments, "--evaluator", "dense") ? a_dense_vertex
                            : has_value(arguments, "--evaluator", "rays")
                                ? a_ray_sample * option_number(arguments, "--samples", 1024)
                            : has_value(arguments, "--colours", "fitted")   ? a_fitted_vertex
                            : has_value(arguments, "--occlusion", "fields") ? a_vertex_by_fields
                                                                            : a_vertex;
        if (searches(arguments))
            return {setup_of(scene) + a_direct_choice, a_vertex * all_vertices(search_start(scene)),
                    scene_bytes(scene, shaded_vertex_bytes)};
        if (has_option(arguments, "--refine"))
            return {setup_of(scene), refinement_work(arguments), scene_bytes(scene, bounced_vertex_bytes)};
        const bool is_whole = possible_division(arguments) == Division::undivided;
        return {setup_of(scene), each * vertices * (has_option(arguments, "--pass") ? 3 : 1),
                scene_bytes(scene, is_whole ? bounced_vertex_bytes : shaded_vertex_bytes)};
    }
    if (command == "reference")
        return {reading_of(scene),
                a_light_of_a_pixel * pixels * std::max(64.0, option_number(arguments, "--lights", 1024)),
                scene_bytes(scene, 0)};
    if (command == "relight") {
        const double frames =
            option_number(arguments, "--last-frame", option_number(arguments, "--frames", 48)) -
            option_number(arguments, "--first-frame", 1) + 1;
        return {setup_of(scene) + a_transfer_vertex * vertices,
                std::max(1.0, frames) * (a_frame_vertex * vertices + a_frame_pixel * pixels),
                scene_bytes(scene, transfer_vertex_bytes)};
    }
    return {setup_of(scene), 0, scene_bytes(scene, 0)};
}

}  // namespace haarfield
