#include "fields/field/field_file.h"
#include "fields/vdb/vdb_file.h"
#include "tools/command.h"
#include "tools/model_info.h"
#include "tools/scene_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct InfoOptions {
    std::string field;
    bool json = false;
};

nlohmann::ordered_json vector_json(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

nlohmann::ordered_json error_json(const SamplerError& error) {
    return {{"relative", error.relative}, {"bands", error.band}};
}

nlohmann::ordered_json summary_json(const FieldSummary& field) {
    return {
        {"entity", field.entity},
        {"key", field.keys.whole.hex()},
        {"surroundings", field.keys.surroundings.hex()},
        {"bytes", field.file_bytes},
        {"samples", field.planar.sample_count() + field.spherical.sample_count() + field.local_samples},
        {"planar",
         {{"samples", field.planar.sample_count()},
          {"rings", field.planar.rings},
          {"angles", field.planar.angles},
          {"outer_radius", field.planar.outer_radius}}},
        {"spherical",
         {{"samples", field.spherical.sample_count()},
          {"shells", field.spherical.shells},
          {"polar", field.spherical.polar},
          {"azimuths", field.spherical.azimuths},
          {"outer_radius", field.spherical.outer_radius}}},
        {"local", {{"samples", field.local_samples}}},
        {"cubemaps", field.cubemaps},
        {"faces", field.faces},
        {"nodes", field.nodes},
        {"face_size", field.settings.face_size},
        {"coefficients", field.settings.coefficients},
        {"relative_l2_error", field.settings.relative_l2_error},
        {"error",
         {{"planar", error_json(field.error.planar)}, {"spherical", error_json(field.error.spherical)}}},
        {"bounds", {{"lower", vector_json(field.bounds.lower)}, {"upper", vector_json(field.bounds.upper)}}}};
}

/// Prints every other band: the distance up to which it reaches, and the error of visibility there.
template <class Sampler>
void print_bands(const CommandContext& context, const char* name, const Sampler& sampler,
                 const SamplerError& error) {
    context.print("\n  {}    ", name);
    for (std::size_t band = 1; band < SamplerError::bands; band += 2)
        context.print(
            " {:.1f} % to {:.2g} m{}", 100 * std::max(error.band[band - 1], error.band[band]),
            distance_at(double(band + 1) / SamplerError::bands, sampler.outer_radius, sampler.growth),
            band + 1 < SamplerError::bands ? "," : "");
}

void print_summary(const FieldSummary& field, const CommandContext& context) {
    const Vec3f size = field.bounds.upper - field.bounds.lower;
    context.print("entity      {}\n", field.entity);
    context.print("size        {:.3g} x {:.3g} x {:.3g} m\n", size.x, size.y, size.z);
    context.print("planar      {} samples: {} rings of {}, to {:.3g} m\n", field.planar.sample_count(),
                  field.planar.rings, field.planar.angles, field.planar.outer_radius);
    context.print("spherical   {} samples: {} shells of {} x {}, to {:.3g} m\n",
                  field.spherical.sample_count(), field.spherical.shells, field.spherical.polar,
                  field.spherical.azimuths, field.spherical.outer_radius);
    context.print("local       {} samples\n", field.local_samples);
    context.print("cubemaps    {} distinct cubemaps of {} distinct faces, with {} nodes\n", field.cubemaps,
                  field.faces, field.nodes);
    context.print("kept        {} of {} wavelets per face",
                  field.settings.coefficients == 0 ? std::string("all")
                                                   : fmt::format("at most {}", field.settings.coefficients),
                  field.settings.face_size * field.settings.face_size - 1);
    if (field.settings.relative_l2_error > 0)
        context.print(
            ", with an error of up to {:g} of the L2 norm of visibility or occlusion, whichever is smaller",
            field.settings.relative_l2_error);
    context.print("\nerror       {:.1f} % of occlusion on the ground, {:.1f} % around (RMS between samples)",
                  100 * field.error.planar.relative, 100 * field.error.spherical.relative);
    print_bands(context, "ground", field.planar, field.error.planar);
    print_bands(context, "around", field.spherical, field.error.spherical);
    context.print("\nfile        {:.2f} MB\nkey         {}\n", static_cast<double>(field.file_bytes) / 1e6,
                  field.keys.whole.hex());
}

nlohmann::ordered_json metadata_json(const std::vector<VdbMetadata>& metadata) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const VdbMetadata& meta : metadata) json[meta.name] = meta.value;
    return json;
}

nlohmann::ordered_json grids_json(const VdbListing& listing) {
    nlohmann::ordered_json grids = nlohmann::ordered_json::array();
    for (const VdbGrid& grid : listing.grids)
        grids.push_back({{"name", grid.name},
                         {"type", grid.type},
                         {"class", grid.grid_class},
                         {"active_voxels", grid.active_voxels},
                         {"leaves", grid.leaves},
                         {"lower", grid.lower},
                         {"upper", grid.upper},
                         {"index_to_world", grid.index_to_world},
                         {"metadata", metadata_json(grid.metadata)}});
    return grids;
}

/// Returns the edge lengths of a grid's voxels. [units of the file]
Vec3f voxel_size(const VdbGrid& grid) {
    const auto row = [&](std::size_t r) {
        return Vec3f(Vec3d(grid.index_to_world[4 * r], grid.index_to_world[4 * r + 1],
                           grid.index_to_world[4 * r + 2]))
            .length();
    };
    return {row(0), row(1), row(2)};
}

void print_grids(const VdbListing& listing, const CommandContext& context) {
    for (const VdbGrid& grid : listing.grids) {
        const Vec3f size = voxel_size(grid);
        context.print("grid        {:<20} {:<6} {:>10} active voxels in {} leaves", grid.name, grid.type,
                      grid.active_voxels, grid.leaves);
        if (grid.active_voxels > 0)
            context.print(", {} to {}, of {:.3g} x {:.3g} x {:.3g}", grid.lower, grid.upper, size.x, size.y,
                          size.z);
        context.print("{}\n", grid.grid_class == "unknown" ? "" : ", " + grid.grid_class);
    }
}

Result<ExitCode> run(const InfoOptions& options, CommandContext& context) {
    if (std::filesystem::path(options.field).extension() != ".vdb")
        return print_model(options.field, options.json, context);
    HF_TRY(const VdbListing listing, read_vdb_listing(options.field));
    nlohmann::ordered_json described;
    if (is_field(listing)) {
        HF_TRY(const FieldSummary field, read_field_summary(options.field));
        described = summary_json(field);
        context.report["field"] = described;
        if (!options.json) print_summary(field, context);
    } else {
        described["version"] = listing.version;
        described["metadata"] = metadata_json(listing.metadata);
        if (!options.json)
            context.print("OpenVDB {}, no visibility field; {} grids\n", listing.version,
                          listing.grids.size());
    }
    described["grids"] = grids_json(listing);
    context.report["grids"] = described["grids"];
    if (options.json)
        print(stdout, "{}\n", described.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    else
        print_grids(listing, context);
    return ExitCode::done;
}

}  // namespace

Command info_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("info", "Describe a visibility field, another OpenVDB file or a model");
    const auto options = std::make_shared<InfoOptions>();
    app->add_option("FILE", options->field, "An OpenVDB file (.vdb), or a model")->required()->type_name("");
    app->add_flag("--json", options->json, "Print JSON");
    app->footer(
        "Example:\n  haarfield info out/chair/fields/chair.vdb\n  haarfield info scenes/meshes/chair.obj");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
