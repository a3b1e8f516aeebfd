#include "fields/field/field_file.h"
#include "tools/command.h"
#include "tools/model_info.h"
#include "tools/scene_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct InfoOptions {
    std::string field;
    bool json = false;
    bool allow_unsealed = false;
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
        {"sealed", field.sealed},
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
    context.print("\nfile        {:.2f} MB, {}\nhash        {}\n",
                  static_cast<double>(field.file_bytes) / 1e6, field.sealed ? "sealed" : "not sealed",
                  field.keys.whole.hex());
}

Result<ExitCode> run(const InfoOptions& options, CommandContext& context) {
    if (std::filesystem::path(options.field).extension() != ".vdb")
        return print_model(options.field, options.json, context);
    HF_TRY(const FieldSummary field,
           read_field_summary(options.field, options.allow_unsealed ? Unsealed::allowed : Unsealed::refused));
    const nlohmann::ordered_json summary = summary_json(field);
    context.report["field"] = summary;
    if (options.json)
        print(stdout, "{}\n", summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    else
        print_summary(field, context);
    return ExitCode::done;
}

}  // namespace

Command info_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("info", "Describe a visibility field or a model");
    const auto options = std::make_shared<InfoOptions>();
    app->add_option("FILE", options->field, "The field (.vdb), or a model")->required()->type_name("");
    app->add_flag("--json", options->json, "Print JSON");
    add_unsealed_option(*app, options->allow_unsealed);
    app->footer(
        "Example:\n  haarfield info out/chair/fields/chair.vdb\n  haarfield info scenes/meshes/chair.obj");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
