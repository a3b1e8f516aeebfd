/// haarfield_study: the measurements of study.h.

#include <fmt/format.h>
#include <hwy/targets.h>

#include <CLI/CLI.hpp>
#include <fstream>

#include "tests/studies/study.h"

namespace {

using namespace haarfield::baseline;

/// Returns the best available instruction set, whose number is the lowest bit.
std::string instruction_set() {
    const std::int64_t supported = hwy::SupportedTargets();
    return hwy::TargetName(supported & -supported);
}

int write_plot(const std::vector<PlotPanel>& panels, const std::string& file) {
    if (file.empty()) return 0;
    std::ofstream stream(file);
    stream << svg_plot(panels);
    stream.close();
    if (stream) return 0;
    fmt::print(stderr, "{}: can not be written\n", file);
    return 1;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Measures the product integral against the baselines, on one thread, on the shipped scene.",
                 "haarfield_study");
    app.require_subcommand(1);
    std::string file;
    std::size_t vertices = 0;
    bool avx2 = false;
    app.add_flag("--avx2", avx2, "No newer instructions than AVX2");
    app.add_option(
           "--vertices", vertices,
           "So many; default: 256, for complexity 16, for crowd 2000, for occlusion 20000, for frame, "
           "relight, view and meshes 180000")
        ->check(CLI::Range(1, 1000000));
    app.add_subcommand("baselines", "Time and error of every method");
    CLI::App* const complexity =
        app.add_subcommand("complexity", "The paper's complexity table, with exponents");
    CLI::App* const depth = app.add_subcommand("depth", "The paper's figure 4: time and error against depth");
    CLI::App* const meshes =
        app.add_subcommand("meshes", "Picture error against vertices, even or refined, sampled or fitted");
    MeshStudyOptions mesh_options;
    meshes->add_option("--fields", mesh_options.fields, "Folder of the visibility fields")
        ->capture_default_str();
    meshes->add_option("--reference", mesh_options.reference,
                       "A picture; default: that of a finer even mesh");
    meshes->add_option("--environment", mesh_options.environment,
                       "A lat-long image; default: the scene's sky");
    meshes->add_option("--exposure", mesh_options.exposure, "In stops");
    CLI::App* const crowd = app.add_subcommand("crowd", "Time per vertex among many chairs, turned and not");
    CLI::App* const frame = app.add_subcommand("frame", "Time of whole frames, all threads");
    std::string scene;
    CLI::App* const occlusion =
        app.add_subcommand("occlusion", "Time and error of bake's --occlusion, against the dense oracle");
    occlusion->add_option("SCENE", scene, "A scene file with a sky")->required()->type_name("");
    CLI::App* const view = app.add_subcommand(
        "view", "Time from gesture to frame, and to the end of a job, in sessions of view");
    view->add_option("SCENE", scene, "A scene file with a chair")->required()->type_name("");
    CLI::App* const relight =
        app.add_subcommand("relight", "Time of a session's frames, and their error against commits");
    relight->add_option("SCENE", scene, "A scene file with a chair")->required()->type_name("");
    relight->add_option("--environment", mesh_options.environment,
                        "A lat-long image; default: the scene's light");
    CLI::App* const session = app.add_subcommand(
        "session", "Least times of a session's frames, a gesture for each word of the input");
    session->add_option("SCENE", scene, "A scene file")->required()->type_name("");
    CLI::App* const error =
        app.add_subcommand("error", "The true error of bakes, next to the one they report");
    ErrorStudyOptions error_options;
    error->add_option("SCENE", scene, "A scene file")->required()->type_name("");
    error->add_option("--environment", error_options.environment,
                      "A lat-long image; default: the scene's light");
    error
        ->add_option("--targets", error_options.targets,
                     "In per cent, `off` or `refine`; default: off,refine,2,1,0.5")
        ->delimiter(',');
    error->add_option("--width", error_options.width, "Of the picture; default: the scene's");
    error->add_option("--pixels", error_options.pixels, "At which the truth is computed")
        ->capture_default_str();
    error->add_option("--pictures", error_options.pictures,
                      "Existing folder for a picture of each bake and a list of its largest errors");
    CLI::App* const rivals =
        app.add_subcommand("rivals", "Whole bakes next to bakes by rays with the same error");
    RivalStudyOptions rival_options;
    rivals->add_option("--rows", rival_options.rows, "Scenes; default: all")
        ->delimiter(',')
        ->check(CLI::IsMember(rival_rows()));
    rivals->add_option("--points", rival_options.points, "Vertices at which errors are measured")
        ->capture_default_str();
    rivals->add_option("--scale", rival_options.scale, "Factor of the numbers of vertices and field samples")
        ->check(CLI::Range(1e-3, 1.0))
        ->capture_default_str();
    rivals->add_option("--repeats", rival_options.repeats, "Of each bake; the fastest counts")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    CLI::App* const povray = app.add_subcommand(
        "povray", "Imports of POV-Ray scenes against POV-Ray: evaluation, silhouettes, colours");
    std::vector<std::string> povray_files;
    int povray_detail = 48;
    povray->add_option("FILE", povray_files, "Scenes (.pov)")->required()->type_name("");
    povray->add_option("--detail", povray_detail, "As that of `import`")->capture_default_str();
    double povray_seconds = 400;
    povray->add_option("--seconds", povray_seconds, "Wall time after which an import is ended")
        ->capture_default_str();
    std::string povray_pictures;
    povray->add_option("--pictures", povray_pictures, "A folder for the pairs of unlit pictures");
    std::size_t frames = 10;
    session->add_option("--frames", frames, "Of a gesture")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    for (CLI::App* const plotted : {complexity, depth, meshes})
        plotted->add_option("-o,--output", file, "Draw it, too: an SVG file");
    CLI11_PARSE(app, argc, argv);

    if (avx2) {
        hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~(HWY_AVX2 - 1));
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    fmt::print("{}, {}\n", instruction_set(), __VERSION__);
    const auto vertices_or = [vertices](std::size_t otherwise) {
        return vertices > 0 ? vertices : otherwise;
    };
    if (complexity->parsed()) return write_plot(study_complexity(vertices_or(16)), file);
    if (depth->parsed()) return write_plot(study_depth(vertices_or(256)), file);
    if (meshes->parsed()) return write_plot(study_meshes(vertices_or(180000), mesh_options), file);
    if (occlusion->parsed())
        study_occlusion(scene, vertices_or(20000));
    else if (view->parsed())
        study_view(scene, vertices_or(180000));
    else if (relight->parsed())
        study_relight(scene, vertices_or(180000), mesh_options.environment);
    else if (session->parsed())
        study_session(scene, frames);
    else if (povray->parsed())
        study_povray(povray_files, povray_detail, povray_seconds, povray_pictures);
    else if (error->parsed())
        study_error(scene, error_options);
    else if (rivals->parsed())
        study_rivals(rival_options);
    else if (frame->parsed())
        study_frame(vertices_or(180000));
    else if (crowd->parsed())
        study_crowd(vertices_or(2000));
    else
        study_baselines(vertices_or(256));
    return 0;
}
