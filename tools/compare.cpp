#include "bridge/pictures/comparison_report.h"
#include "fields/file/input_file.h"
#include "fields/file/write_file.h"
#include "tools/command.h"
#include "tools/number_option.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

struct CompareOptions {
    std::string image, reference;
    std::string output;
    std::string mask;
    double min_psnr = 0;  // [dB]
};

// Returns the report of a picture, if bake or reference wrote one with the picture's name next to it.
nlohmann::json report_beside(const std::filesystem::path& image) {
    constexpr std::uint64_t largest_report = std::uint64_t{64} << 20;
    const Result<std::string> text =
        read_whole_file(std::filesystem::path(image).replace_extension(".json"), largest_report);
    if (!text) return nlohmann::json::object();
    nlohmann::json report = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
    return report.is_object() ? report : nlohmann::json::object();
}

void add_fact(ComparisonReport& page, const nlohmann::json& report, const char* key, const char* name,
              const char* format) {
    if (const auto value = report.find(key); value != report.end() && value->is_number())
        page.facts.emplace_back(name, fmt::format(fmt::runtime(format), value->get<double>()));
}

ComparisonReport report_page(const CompareOptions& options, const CommandContext& context) {
    ComparisonReport page;
    page.title = std::filesystem::absolute(options.output).lexically_normal().filename().string();
    page.image_name = std::filesystem::path(options.image).stem().string();
    page.reference_name = std::filesystem::path(options.reference).stem().string();
    const nlohmann::json image = report_beside(options.image), reference = report_beside(options.reference);
    add_fact(page, image, "vertices", "vertices", "{:.0f}");
    add_fact(page, image, "shade_seconds", "shading time of the vertices", "{:.2f} s");
    add_fact(page, image, "seconds", "total time of the first picture", "{:.1f} s");
    add_fact(page, reference, "lights", "lights of the second picture", "{:.0f}");
    add_fact(page, reference, "seconds", "total time of the second picture", "{:.1f} s");
    for (const nlohmann::json* report : {&image, &reference})
        if (const auto line = report->find("command_line"); line != report->end() && line->is_string())
            page.commands.push_back(line->get<std::string>());
    page.commands.push_back(context.command_line);
    return page;
}

Result<ExitCode> run(const CompareOptions& options, CommandContext& context) {
    HF_TRY(const Image image, read_image(options.image));
    HF_TRY(const Image reference, read_image(options.reference));
    ImageDifferenceOptions wanted;
    if (!options.mask.empty()) {
        HF_TRY(wanted.mask, read_image(options.mask));
    }
    HF_TRY(const ImageDifference difference, image_difference(image, reference, wanted));

    if (context.progress.stop.stop_requested()) return interruption();
    const std::filesystem::path output = options.output;
    HF_TRY_DONE(make_folder(output));
    // The brightest colour is for the error that 1 % of the pixels exceed, with a lower limit that keeps
    // noise from looking like errors.
    const float brightest = std::max(0.05f, static_cast<float>(difference.flip_99));
    const Image picture = difference_picture(difference, image.width, image.height, brightest);
    HF_TRY_DONE(write_image(picture, output / "difference.png"));
    ComparisonReport page = report_page(options, context);
    page.image = &image;
    page.reference = &reference;
    page.difference = &difference;
    if (reference.relative_error)
        page.facts.emplace_back("own relative error of the second picture",
                                fmt::format("{:.2f} %", 100 * *reference.relative_error));
    HF_TRY_DONE(write_comparison_report(page, output / "report.html"));

    context.report["image"] = options.image;
    context.report["reference"] = options.reference;
    context.report["pixels"] = difference.pixels;
    context.report["psnr_db"] = difference.psnr_db;
    context.report["rmse"] = difference.rmse;
    context.report["relative_rmse"] = difference.relative_rmse;
    context.report["bias"] = difference.bias;
    context.report["ssim"] = difference.ssim;
    context.report["flip"] = difference.flip;
    context.report["flip_99"] = difference.flip_99;
    if (reference.relative_error) context.report["reference_relative_error"] = *reference.relative_error;
    context.print(
        "psnr           {:.2f} dB\nrelative rmse  {:.4f}\nrmse           {:.6f}\nbias           {:+.4f}\n"
        "ssim           {:.4f}\nflip           {:.4f}\npixels         {}\nreport         {}\n",
        difference.psnr_db, difference.relative_rmse, difference.rmse, difference.bias, difference.ssim,
        difference.flip, difference.pixels, (output / "report.html").string());
    if (reference.relative_error)
        context.print("reference      own relative error {:.4f}\n", *reference.relative_error);
    if (difference.psnr_db >= options.min_psnr) return ExitCode::done;
    context.message(
        fmt::format("PSNR is {:.2f} dB; expected at least {} dB", difference.psnr_db, options.min_psnr));
    return ExitCode::images_differ;
}

}  // namespace

Command compare_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("compare", "Compare a picture with a reference");
    const auto options = std::make_shared<CompareOptions>();
    app->add_option("A", options->image, "The picture")->required()->type_name("");
    app->add_option("B", options->reference, "The reference")->required()->type_name("");
    app->add_option("-o,--output", options->output, "Folder for difference.png and report.html")
        ->required()
        ->type_name("DIR");
    app->add_option("--mask", options->mask, "Compare only pixels at which this picture is bright")
        ->type_name("FILE");
    add_number(*app, "--min-psnr", options->min_psnr, "Exit with code 3 if the PSNR is lower [dB]", {0, 99})
        ->type_name("X");
    app->footer(
        "Pixels are compared where both pictures are covered. The page quotes the command lines of a\n"
        "picture if its --report is stored next to it (baked.json next to baked.exr).\n"
        "Example:\n"
        "  haarfield compare out/chair/baked.exr out/chair/reference.exr -o out/chair --min-psnr 30");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
