#include "tools/render_options.h"

#include "tools/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <type_traits>

namespace haarfield {

namespace {

constexpr Range shares{0, 1, false, true};
constexpr const char* automatic = "auto";

/// An option that is a number; an std::optional one may be missing.
///
/// of  returns the member of RenderChoices.
template <class Member>
RenderOption number(RenderOption row, const Range& range, Member of) {
    using Value = std::decay_t<decltype(of(std::declval<RenderChoices&>()))>;
    row.range = range;
    if constexpr (requires { typename Value::value_type; }) {
        row.is_optional = true;
        row.is_whole = std::is_integral_v<typename Value::value_type>;
        row.text = [of](const RenderChoices& c) { return of(c) ? fmt::format("{}", *of(c)) : ""; };
        row.set_text = [of](RenderChoices& c, const std::string& text) {
            of(c) = static_cast<typename Value::value_type>(std::stod(text));
        };
    } else {
        row.is_whole = std::is_integral_v<Value>;
        row.text = [of](const RenderChoices& c) { return fmt::format("{}", of(c)); };
        row.set_text = [of](RenderChoices& c, const std::string& text) {
            of(c) = static_cast<Value>(std::stod(text));
        };
    }
    return row;
}

/// An option that is an enumerator.
///
/// words  of the enumerators 0, 1, 2 ...
template <class Member>
RenderOption choice(RenderOption row, std::vector<std::string> words, Member of) {
    using Value = std::decay_t<decltype(of(std::declval<RenderChoices&>()))>;
    row.text = [of, words](const RenderChoices& c) { return words[static_cast<std::size_t>(of(c))]; };
    row.set_text = [of, words](RenderChoices& c, const std::string& text) {
        of(c) = static_cast<Value>(std::ranges::find(words, text) - words.begin());
    };
    row.words = std::move(words);
    return row;
}

/// An option that is a bool, or an enumerator in which 1 represents true.
template <class Member>
RenderOption flag(RenderOption row, Member of) {
    row.is_flag = true;
    return choice(std::move(row), {"false", "true"}, of);
}

std::vector<std::string> words_in(const std::string& list) {
    std::vector<std::string> words;
    for (std::size_t first = 0; first < list.size();) {
        const std::size_t end = std::min(list.find(',', first), list.size());
        words.push_back(list.substr(first, end - first));
        first = end + 1;
    }
    return words;
}

/// Returns the number in a text, which may be a percentage if the option is a share.
std::optional<double> number_of(const RenderOption& row, std::string_view text) {
    if (!row.is_share || !text.ends_with('%')) return number_in(*row.range, text, row.is_whole);
    const std::optional<double> percent = number_in({0, 100}, text.substr(0, text.size() - 1));
    if (!percent || !row.range->contains(*percent / 100)) return std::nullopt;
    return *percent / 100;
}

RenderOption error() {
    RenderOption row{
        "error",
        OptionSet::bake,
        shown_group,
        "E",
        "The error to reach, such as 1%; off: no search",
        "The relative RMS error of linear radiance over the pixels of the picture, or over all "
        "surfaces with --everywhere. The bake chooses vertices, colours and rays, and prints the "
        "error that it reaches. --refine, --original-vertices, `--colours fitted` and other "
        "evaluators turn the search off."};
    row.words = {"off"};
    row.range = Range{1e-4, 1};
    row.is_share = true;
    row.text = [](const RenderChoices& c) {
        const std::optional<double> target = target_error(c);
        return target ? fmt::format("{}", *target) : "off";
    };
    row.set_text = [](RenderChoices& c, const std::string& text) { c.error = text; };
    return row;
}

RenderOption face_size() {
    RenderOption row{
        "face-size",
        OptionSet::fields,
        accuracy_group,
        "N",
        "Texels along an edge of the cubemaps",
        "`bake --error` begins with 16 and takes up to N where direct light needs it; without this "
        "option, up to 128."};
    row.words = {"16", "32", "64", "128", "256"};
    row.is_whole = true;
    row.text = [](const RenderChoices& c) { return std::to_string(c.entities.face_size); };
    row.set_text = [](RenderChoices& c, const std::string& text) {
        c.entities.face_size = c.shading.face_size = c.bake.most_face_size = std::stoi(text);
    };
    return row;
}

RenderOption bounces() {
    RenderOption row{"bounces",
                     OptionSet::occlusion,
                     shown_group,
                     "N",
                     "Reflections between diffuse surfaces; 0: direct light only",
                     "`auto` adds bounces until the next one changes radiance by less than a thousandth."};
    row = number(
        std::move(row), {0, any_bounces}, [](auto& c) -> auto& { return c.shading.bounces.most; });
    row.words = {automatic};
    row.text = [text = row.text](const RenderChoices& c) {
        return c.shading.bounces.most == any_bounces ? automatic : text(c);
    };
    row.set_text = [set = row.set_text](RenderChoices& c, const std::string& text) {
        set(c, text == automatic ? std::to_string(any_bounces) : text);
    };
    return row;
}

RenderOption passes() {
    RenderOption row{"pass",
                     OptionSet::bake,
                     shown_group,
                     "PASS",
                     "Additional passes, separated by commas",
                     "Each pass is written as PASS.png, as PASS/NAME_PASS.pov and as values of the mesh. "
                     "`diffuse` and `specular`: the components of radiance, without images. `indirect`: "
                     "indirect light. `irradiance`: in W/m^2; its picture shows a white diffuse surface. "
                     "`occlusion`: the unoccluded fraction of the hemisphere. `own-shadow`: each object as "
                     "if it were alone."};
    row.words = pass_names();
    row.is_list = true;
    row.text = [](const RenderChoices& c) { return fmt::format("{}", fmt::join(c.bake.passes, ",")); };
    row.set_text = [](RenderChoices& c, const std::string& text) { c.bake.passes = words_in(text); };
    return row;
}

std::vector<RenderOption> table() {
    using Set = OptionSet;
    std::vector<RenderOption> rows;
    const auto add = [&](RenderOption row) { rows.push_back(std::move(row)); };

    add(error());
    add(flag(
        {"everywhere", Set::bake, shown_group, "", "Measure the error over all surfaces by area",
         "For meshes that are viewed from all sides. Without it, the error is that of the camera's "
         "picture."},
        [](auto& c) -> auto& { return c.bake.everywhere; }));
    add(bounces());
    add(passes());
    add(flag(
        {"original-vertices", Set::vertices, shown_group, "",
         "Bake the vertices that the model files list, in the files' order",
         "The mesh has these vertices, with the faces of the files. The scene's fine_vertices have no "
         "effect. Where normals or materials differ, a vertex has the mean."},
        [](auto& c) -> auto& { return c.entities.original_vertices; }));

    add(number(
        {"refine", Set::bake, accuracy_group, "E", "Split triangles where interpolation errs by more",
         "The error of interpolated radiance is relative to the radiance plus the mean radiance of "
         "the scene."},
        {1e-4, 1}, [](auto& c) -> auto& { return c.bake.refine; }));
    add(number(
        {"vertex-budget", Set::bake, accuracy_group, "N", "The largest number of vertices",
         "The default is 200000 with --error and 60000 with --refine, or 1.5 times the number of vertices of "
         "the models if that is more; with --error at least what the scene asks for."},
        {1, 50e6}, [](auto& c) -> auto& { return c.bake.vertex_budget; }));
    add(choice(
        {"occlusion", Set::occlusion, accuracy_group, "", "Occlusion by other objects",
         "`fields`: interpolate the precomputed fields (fast). `exact`: rasterize at each vertex. "
         "`auto`: rasterize only where a field's estimated error exceeds --occlusion-error."},
        {"fields", "exact", automatic}, [](auto& c) -> auto& { return c.shading.occlusion; }));
    add(number(
        {"occlusion-error", Set::occlusion, accuracy_group, "E",
         "RMS error of visibility that `--occlusion auto` accepts",
         "`info` prints the estimated errors of a field."},
        shares, [](auto& c) -> auto& { return c.shading.occlusion_error; }));
    add(number(
        {"reach", Set::occlusion, accuracy_group, "R", "Distance to which objects cast shadows",
         "In radii of the object's bounding sphere. Beyond, an object occludes at most 1 / R^2 of "
         "the light."},
        {1, 1e4}, [](auto& c) -> auto& { return c.shading.reach; }));
    add(choice(
        {"colours", Set::bake, accuracy_group, "", "How colours of vertices are chosen",
         "`sampled`: the radiance at the vertices. `fitted`: the colours whose interpolation is "
         "nearest to the radiance on the triangles."},
        {"sampled", "fitted"}, [](auto& c) -> auto& { return c.bake.colours; }));
    add(face_size());
    add(number(
        {"visibility-error", Set::fields, accuracy_group, "E",
         "Error of visibility by dropped wavelets; 0: drop none",
         "The L2 error of each cubemap, relative to its blocked or unoccluded directions, whichever "
         "are fewer."},
        shares, [](auto& c) -> auto& { return c.entities.relative_l2_error; }));
    add(number(
        {"coefficients", Set::fields, accuracy_group, "M",
         "The largest number of wavelets of visibility per face; 0: no limit", ""},
        {0, 65536}, [](auto& c) -> auto& { return c.entities.coefficients; }));
    add(number(
        {"light-coefficients", Set::lighting, accuracy_group, "M",
         "Wavelets of the lighting per cubemap face; 0: all", ""},
        {0, 65536}, [](auto& c) -> auto& { return c.shading.light_coefficients; }));
    add(number(
        {"source-directions", Set::lighting, accuracy_group, "N",
         "Factor on the number of directions of a sun or bright window",
         "Each direction casts a sharp shadow; many shadows are a penumbra. `bake --error` begins with this "
         "factor and takes 16 where penumbrae need it."},
        {1, 64}, [](auto& c) -> auto& { return c.shading.sources.direction_factor; }));
    add(number(
        {"pruning-error", Set::frames, accuracy_group, "E",
         "Error of frames by pruned transfer vectors; 0: no pruning",
         "The relative change of radiance while something varies."},
        shares, [](auto& c) -> auto& { return c.transfer.pruning_error; }));

    add(number(
        {"depth", Set::depth, speed_group, "D", "Levels of the trees; fewer are faster and coarser", ""},
        {0, full_depth}, [](auto& c) -> auto& { return c.shading.depth; }));
    add(choice(
        {"evaluator", Set::bake, speed_group, "", "How light is integrated",
         "`tree`: wavelet product integrals. `dense`: plain sums over texels, slow; indirect light as with "
         "`tree`. `rays`: Monte Carlo integration by rays and paths, without fields."},
        {"tree", "dense", "rays"}, [](auto& c) -> auto& { return c.bake.evaluator; }));
    add(number(
        {"samples", Set::bake, speed_group, "N", "Samples per vertex with `--evaluator rays`",
         "More samples are slower and less noisy. Indirect light has a quarter as many paths."},
        {1, 1e8}, [](auto& c) -> auto& { return c.bake.samples; }));

    return rows;
}

}  // namespace

std::optional<double> target_error(const RenderChoices& choices) {
    const RenderOption& row = render_option("error");
    if (choices.error == "off") return std::nullopt;
    if (!choices.error.empty()) return number_of(row, choices.error);
    constexpr double usual = 0.01;
    const BakeOptions& bake = choices.bake;
    const bool is_chosen = bake.refine || bake.colours == BakedColours::fitted ||
                           bake.evaluator != Evaluator::tree || choices.entities.original_vertices;
    return is_chosen ? std::nullopt : std::optional(usual);
}

std::string RenderOption::trouble(const std::string& value) const {
    const std::vector<std::string> given = is_list ? words_in(value) : std::vector{value};
    const auto is_value = [&](const std::string& word) {
        return std::ranges::find(words, word) != words.end() || (range && number_of(*this, word));
    };
    if (!given.empty() && std::ranges::all_of(given, is_value)) return {};
    if (!range) return fmt::format("is {}; expected one of {}", value, values());
    return fmt::format("is {}; expected {}{} {}", value, words.empty() ? "" : words[0] + " or ",
                       is_whole ? "a whole number" : "a number", values());
}

std::string RenderOption::values() const {
    return range ? "in " + range->text() : fmt::format("{{{}}}", fmt::join(words, ","));
}

const std::vector<RenderOption>& render_options() {
    static const std::vector<RenderOption> rows = table();
    return rows;
}

const RenderOption& render_option(std::string_view name) {
    const auto found = std::ranges::find(render_options(), name, &RenderOption::name);
    assert(found != render_options().end());
    return *found;
}

std::vector<const RenderOption*> render_options(std::initializer_list<OptionSet> sets) {
    std::vector<const RenderOption*> rows;
    for (const RenderOption& row : render_options())
        if (std::ranges::find(sets, row.set) != sets.end()) rows.push_back(&row);
    return rows;
}

std::vector<std::string> option_arguments(const RenderChoices& choices,
                                          std::initializer_list<OptionSet> sets) {
    std::vector<std::string> arguments;
    for (const RenderOption* row : render_options(sets)) {
        const std::string text = row->text(choices);
        if (text.empty() || (row->is_flag && text == "false")) continue;
        arguments.push_back("--" + row->name);
        if (!row->is_flag) arguments.push_back(text);
    }
    return arguments;
}

}  // namespace haarfield
