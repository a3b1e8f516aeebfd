#include "bridge/povray_import/wrapped_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "fields/file/input_file.h"

namespace haarfield {
namespace {

using Tokens = std::vector<SceneToken>;
using Kind = SceneToken::Kind;

// Around finishes, until both variants of a file are written. Neither byte occurs in tokens.
constexpr char finish_begin = '\x02', finish_end = '\x03';

constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
constexpr std::size_t most_files = 1000;

template <std::size_t count>
bool is_one_of(std::string_view word, const std::array<const char*, count>& words) {
    return std::ranges::find(words, word) != words.end();
}

bool is_object(std::string_view word) {
    constexpr std::array words{"bicubic_patch",
                               "blob",
                               "box",
                               "cone",
                               "cubic",
                               "cylinder",
                               "difference",
                               "disc",
                               "height_field",
                               "intersection",
                               "isosurface",
                               "julia_fractal",
                               "lathe",
                               "light_group",
                               "merge",
                               "mesh",
                               "mesh2",
                               "object",
                               "ovus",
                               "parametric",
                               "plane",
                               "poly",
                               "polygon",
                               "prism",
                               "quadric",
                               "quartic",
                               "smooth_triangle",
                               "sor",
                               "sphere",
                               "sphere_sweep",
                               "superellipsoid",
                               "text",
                               "torus",
                               "triangle",
                               "union"};
    return is_one_of(word, words);
}

/// Statements that light or fill the space around objects.
bool is_sky(std::string_view word) {
    constexpr std::array words{"background", "sky_sphere", "fog", "rainbow"};
    return is_one_of(word, words);
}

/// Blocks that change neither surfaces nor their pigments.
bool is_extra(std::string_view word) {
    constexpr std::array words{"interior", "media", "photons", "radiosity", "subsurface"};
    return is_one_of(word, words);
}

/// A file's text and tokens.
struct SourceFile {
    std::string name;  ///< For messages.
    std::string text;
    Tokens tokens;
};

/// The right side of a declaration.
struct DeclaredValue {
    const SourceFile* source;
    std::size_t begin, end;  ///< Indices of tokens.
};

class Wrapper {
public:
    explicit Wrapper(std::filesystem::path scene, const WrapOptions& options)
        : scene_(std::move(scene)), options_(options) {}

    Result<WrappedScene> wrapped() {
        // The macros that are called as statements are known only after all files have been read.
        std::size_t known = 0;
        do {
            known = statement_macros_.size();
            result_ = {};
            names_.clear();
            unused_.clear();
            HF_TRY_DONE(add_file(scene_, 0));
        } while (statement_macros_.size() > known);
        for (const std::string& word : unused_order_) result_.unused.push_back(unused_[word]);
        return std::move(result_);
    }

private:
    static constexpr int deepest = 24;

    /// Rewrites a file and returns the name of the result.
    Result<std::string> add_file(const std::filesystem::path& path, int depth) {
        const std::string key = path.lexically_normal().string();
        if (const auto found = names_.find(key); found != names_.end()) return found->second;
        if (names_.size() >= most_files)
            return Error{scene_.string(), fmt::format("includes more than {} files", most_files)};
        const std::size_t index = result_.files.size();
        const std::string name = index == 0 ? "hf_scene.pov" : fmt::format("hf_include_{}.inc", index);
        names_[key] = name;
        result_.files.push_back({name, {}, {}});
        if (!sources_.contains(key)) {
            SourceFile source;
            source.name = path.filename().string();
            if (index == 0) source.name = path.string();
            HF_TRY(source.text, read_whole_file(path, most_bytes));
            SourceFile& kept = sources_[key];
            kept = std::move(source);
            Result<Tokens> tokens = scene_tokens(kept.text);
            if (!tokens) return Error{path.string(), tokens.error().what};
            kept.tokens = *std::move(tokens);
        }
        Text text{*this, sources_[key], depth};
        HF_TRY(std::string rewritten, text.rewritten(index == 0));
        set_variants(rewritten, result_.files[index]);
        return name;
    }

    static void set_variants(const std::string& marked, WrappedScene::File& file) {
        bool in_finish = false;
        for (const char c : marked) {
            if (c == finish_begin) file.emissive_text += "finish{ambient 0 diffuse 0 emission HF_E}";
            if (c == finish_begin || c == finish_end) {
                in_finish = c == finish_begin;
                continue;
            }
            file.text += c;
            if (!in_finish) file.emissive_text += c;
        }
    }

    /// Finds an included file in or below the scene's folder, then in the library.
    std::optional<std::filesystem::path> found_include(std::string_view name) const {
        std::error_code ignored;
        const std::filesystem::path wanted(name);
        std::vector<std::filesystem::path> folders{std::filesystem::absolute(scene_).parent_path()};
        folders.insert(folders.end(), options_.library.begin(), options_.library.end());
        for (const std::filesystem::path& folder : folders) {
            const std::filesystem::path file = std::filesystem::weakly_canonical(folder / wanted, ignored),
                                        top = std::filesystem::weakly_canonical(folder, ignored);
            // An untrusted scene must not read files elsewhere.
            const auto [end, other] = std::mismatch(top.begin(), top.end(), file.begin(), file.end());
            if (end == top.end() && std::filesystem::is_regular_file(file, ignored)) return file;
        }
        return std::nullopt;
    }

    /// One file while it is rewritten.
    class Text {
    public:
        Text(Wrapper& wrapper, const SourceFile& source, int depth)
            : wrapper_(wrapper), source_(source), tokens_(source.tokens), include_depth_(depth) {}

        Result<std::string> rewritten(bool is_main) {
            std::size_t at = 0;
            if (is_main) {
                if (!tokens_.empty() && tokens_[0].is_directive("version")) {
                    at = end_of_expression(tokens_, 1);
                    if (at < tokens_.size() && tokens_[at].is(';')) ++at;
                    HF_TRY_DONE(copy(0, at));
                }
                out_ += "\n#include \"hf_prelude.inc\"\n";
            }
            while (at < tokens_.size()) {
                HF_TRY(at, statement(at, /*in_macro=*/false));
            }
            if (is_main) {
                const std::string& object = wrapper_.options_.object;
                if (!object.empty())
                    out_ += fmt::format("\n#declare HF_A[HF_N]=object{{{}}} HF_Put({})\n", object,
                                        add_statement(0, "object", object));
                out_ += "\n#include \"hf_suffix.inc\"\n";
            }
            return std::move(out_);
        }

    private:
        const SceneToken& token(std::size_t at) const {
            static const SceneToken none;
            return at < tokens_.size() ? tokens_[at] : none;
        }
        std::size_t line(std::size_t at) const {
            return line_of_place(source_.text, at < tokens_.size() ? tokens_[at].begin : 0);
        }
        bool opens(std::size_t at) const { return token(at + 1).is('{'); }
        bool is_call(std::size_t at) const {
            return token(at).kind == Kind::word && token(at + 1).is('(') &&
                   wrapper_.macros_.contains(std::string(token(at).text));
        }
        std::string copied(std::size_t from, std::size_t to) const {
            if (from >= to) return {};
            return source_.text.substr(tokens_[from].begin, tokens_[to - 1].end - tokens_[from].begin);
        }

        std::size_t add_statement(std::size_t at, std::string keyword, std::string name) {
            wrapper_.result_.statements.push_back(
                {source_.name, line(at), std::move(keyword), std::move(name)});
            return wrapper_.result_.statements.size() - 1;
        }

        void note_unused(std::size_t at) {
            const std::string word(token(at).text);
            // The standard includes declare many glasses, most of which a scene does not use.
            if (include_depth_ > 0 && wrapper_.is_library(source_)) return;
            auto& unused = wrapper_.unused_[word];
            if (unused.count++ == 0) {
                unused = {word, source_.name, line(at), 1};
                if (std::ranges::find(wrapper_.unused_order_, word) == wrapper_.unused_order_.end())
                    wrapper_.unused_order_.push_back(word);
            }
        }

        /// Copies the lines between two tokens, without comments.
        void add_blanks(std::size_t from, std::size_t to) {
            if (to <= from) return;
            out_ += ' ';
            out_.append(static_cast<std::size_t>(std::count(source_.text.begin() + std::ptrdiff_t(from),
                                                            source_.text.begin() + std::ptrdiff_t(to), '\n')),
                        '\n');
        }

        /// Copies tokens with the blanks and comments before them. Switches finishes and extras.
        ///
        /// is_value  The first token is the right side of a declaration, which must not become empty.
        Result<Done> copy(std::size_t from, std::size_t to, bool is_value = false) {
            for (std::size_t at = from; at < to;) {
                const std::size_t before = at == 0 ? 0 : tokens_[at - 1].end;
                add_blanks(before, tokens_[at].begin);
                const SceneToken& here = tokens_[at];
                if (here.is_directive("include")) {
                    HF_TRY(at, include(at));
                    continue;
                }
                if (here.is_directive("macro")) note_macro(at);
                if (here.kind == Kind::word && opens(at)) {
                    const std::size_t end = end_of_group(tokens_, at + 1);
                    const bool is_first = is_value && at == from;
                    if (here.text == "finish" && end != 0) {
                        // POV-Ray accepts no conditions in the layers of a texture.
                        out_ += finish_begin + copied(at, end) + finish_end;
                        note_unused_in(at + 2, end);
                        at = end;
                        continue;
                    }
                    if (here.text == "camera" && end != 0 && end <= to) {
                        HF_TRY_DONE(copy_camera(at, end));
                        at = end;
                        continue;
                    }
                    if (is_extra(here.text)) note_unused(at);
                    if (is_extra(here.text) && end != 0 && end <= to && !is_first) {
                        HF_TRY_DONE(guarded("HF_Extras", at, end));
                        at = end;
                        continue;
                    }
                    if (here.text == "light_source" && end != 0 && end <= to && !is_first) {
                        HF_TRY_DONE(guarded("HF_Lights", at, end));
                        at = end;
                        continue;
                    }
                }
                out_ += copied(at, at + 1);
                ++at;
            }
            return Done{};
        }

        void note_unused_in(std::size_t from, std::size_t to) {
            for (std::size_t at = from; at < to; ++at)
                if (token(at).is_word("subsurface") || token(at).is_word("irid")) note_unused(at);
        }

        /// Copies a camera. Without extras, it has no focal blur.
        Result<Done> copy_camera(std::size_t at, std::size_t end) {
            out_ += copied(at, at + 1);
            HF_TRY_DONE(copy(at + 1, end - 1));
            const auto body = std::span(tokens_).subspan(at, end - at);
            if (std::ranges::any_of(body, [](const SceneToken& each) { return each.is_word("aperture"); }))
                out_ += " #if(HF_Extras=0) aperture 0 #end ";
            out_ += '}';
            return Done{};
        }

        Result<Done> guarded(std::string_view number, std::size_t from, std::size_t to) {
            out_ += fmt::format("#if({}) {}", number, copied(from, from + 1));
            HF_TRY_DONE(copy(from + 1, to));
            out_ += " #end ";
            return Done{};
        }

        /// Copies an include, with the name of the rewritten file if it is found.
        Result<std::size_t> include(std::size_t at) {
            if (token(at + 1).kind == Kind::string && include_depth_ < deepest) {
                const auto path = wrapper_.found_include(token(at + 1).text);
                if (path) {
                    HF_TRY(const std::string name, wrapper_.add_file(*path, include_depth_ + 1));
                    out_ += fmt::format("#include \"{}\"", name);
                    return at + 2;
                }
            }
            out_ += copied(at, at + 1);
            return at + 1;
        }

        void note_macro(std::size_t at) {
            if (token(at + 1).kind == Kind::word) wrapper_.macros_.insert(std::string(token(at + 1).text));
        }

        /// Rewrites the statement at `at` and returns the index behind it.
        Result<std::size_t> statement(std::size_t at, bool in_macro) {
            const SceneToken& here = tokens_[at];
            if (here.kind == Kind::directive) return directive(at);
            if (here.kind == Kind::word && opens(at)) {
                const std::size_t end = end_of_group(tokens_, at + 1);
                if (end == 0) return unbalanced(at);
                if (is_light(at)) return light(at, end);
                if (is_object(here.text) && !in_macro) return object(at, end);
                if (is_object(here.text)) {
                    HF_TRY_DONE(copy(at, end));
                    return end;
                }
                if (here.text == "camera") return camera(at, end, in_macro);
                if (is_sky(here.text)) {
                    leave_union(in_macro);
                    HF_TRY_DONE(guarded("HF_Sky", at, end));
                    enter_union(in_macro);
                    return end;
                }
                if (here.text == "global_settings") {
                    leave_union(in_macro);
                    HF_TRY_DONE(guarded("HF_Settings", at, end));
                    enter_union(in_macro);
                    return end;
                }
                if (here.text == "default") {
                    leave_union(in_macro);
                    HF_TRY_DONE(copy(at, end));
                    enter_union(in_macro);
                    return end;
                }
                HF_TRY_DONE(copy(at, end));
                return end;
            }
            if (here.is_word("max_trace_level")) {
                const std::size_t end = end_of_expression(tokens_, at + 1);
                leave_union(in_macro);
                HF_TRY_DONE(copy(at, end));
                enter_union(in_macro);
                return end;
            }
            if (is_call(at)) {
                const std::size_t end = end_of_group(tokens_, at + 1);
                if (end == 0) return unbalanced(at);
                const std::string name(here.text);
                wrapper_.statement_macros_.insert(name);
                if (!in_macro) {
                    const std::size_t id = add_statement(at, name, name);
                    out_ += fmt::format("\n#declare HF_Id={}; #declare HF_A[HF_N]=union{{", id);
                }
                HF_TRY_DONE(copy(at, end));
                if (!in_macro) out_ += "} HF_Put(HF_Id) ";
                return end;
            }
            HF_TRY_DONE(copy(at, at + 1));
            return at + 1;
        }

        /// Copies the opening part of a statement whose braces do not close within its condition.
        Result<std::size_t> unbalanced(std::size_t at) {
            std::size_t depth = 0, end = at;
            do {
                depth += token(end).is('{');
                depth -= token(end).is('}') && depth > 0;
                ++end;
            } while (end < tokens_.size() && (depth > 0 || end < at + 2));
            HF_TRY_DONE(copy(at, end));
            return end;
        }

        void leave_union(bool in_macro) {
            if (in_macro) out_ += "} HF_Put(HF_Id) ";
        }
        void enter_union(bool in_macro) {
            if (in_macro) out_ += " #declare HF_A[HF_N]=union{";
        }

        Result<std::size_t> directive(std::size_t at) {
            const std::string_view word = token(at).text;
            if (word == "macro") return macro(at);
            if (word == "declare" || word == "local") return declaration(at);
            if (word == "default" && token(at + 1).is('{')) {
                const std::size_t end = end_of_group(tokens_, at + 1);
                HF_TRY_DONE(copy(at, end == 0 ? at + 1 : end));
                return end == 0 ? at + 1 : end;
            }
            std::size_t end = at + 1;
            if (word == "debug" || word == "warning" || word == "error" || word == "version" ||
                word == "render" || word == "statistics")
                end = end_of_expression(tokens_, at + 1);
            else if (word == "fopen")
                end = std::min(tokens_.size(), end_of_expression(tokens_, at + 2) + 1);
            else if (word == "undef" || word == "fclose" || word == "include")
                end = std::min(tokens_.size(), at + 2);
            else if (token(at + 1).is('('))
                end = std::max(end, end_of_group(tokens_, at + 1));
            HF_TRY_DONE(copy(at, end));
            return end;
        }

        /// Rewrites a macro. Statements at the top level of a macro that is called as a statement leave the
        /// union around its call.
        Result<std::size_t> macro(std::size_t at) {
            note_macro(at);
            const std::size_t end = end_of_block(tokens_, at);
            std::size_t body = at + 2;
            if (token(body).is('(')) body = std::max(body, end_of_group(tokens_, body));
            if (!wrapper_.statement_macros_.contains(std::string(token(at + 1).text)) || end <= body) {
                HF_TRY_DONE(copy(at, end));
                return end;
            }
            HF_TRY_DONE(copy(at, body));
            for (std::size_t i = body; i < end;) {
                HF_TRY(i, statement(i, /*in_macro=*/true));
            }
            return end;
        }

        Result<std::size_t> declaration(std::size_t at) {
            std::size_t value = at + 1;
            while (value < tokens_.size() && !tokens_[value].is('=')) ++value;
            // An index of an array may be an expression, but not a long one.
            if (value > at + 40 || value == tokens_.size()) {
                HF_TRY_DONE(copy(at, at + 1));
                return at + 1;
            }
            const std::size_t end = end_of_expression(tokens_, ++value);
            const std::string name(token(at + 1).text);
            wrapper_.values_[name] = {&source_, value, end};
            if (is_object(token(value).text) && opens(value)) wrapper_.result_.declared.insert(name);
            HF_TRY_DONE(copy(at, value));
            HF_TRY_DONE(copy(value, end, /*is_value=*/true));
            return end;
        }

        Result<std::size_t> object(std::size_t at, std::size_t end) {
            std::string keyword(token(at).text), name;
            if (keyword == "object" && token(at + 2).kind == Kind::word) name = token(at + 2).text;
            const std::size_t id = add_statement(at, keyword, name);
            const bool is_group = keyword == "light_group";
            const std::size_t before = at == 0 ? 0 : tokens_[at - 1].end;
            add_blanks(before, tokens_[at].begin);
            out_ += fmt::format("\n#declare HF_A[HF_N]={}", is_group ? "union{" : "");
            out_ += copied(at, at + 1);
            HF_TRY_DONE(copy(at + 1, end));
            out_ += fmt::format("{} HF_Put({}) ", is_group ? "}" : "", id);
            return end;
        }

        /// A camera. In a survey, its position is evaluated.
        Result<std::size_t> camera(std::size_t at, std::size_t end, bool in_macro) {
            wrapper_.result_.has_camera = true;
            leave_union(in_macro);
            for (std::size_t i = at + 2; i + 1 < end; ++i)
                if (token(i).is_word("location")) {
                    const std::size_t behind = end_of_expression(tokens_, i + 1);
                    if (behind > i + 1)
                        out_ +=
                            fmt::format("\n#if(HF_Survey) #declare HF_V=(<0,0,0>+{}); HF_Place(HF_V) #end ",
                                        copied(i + 1, behind));
                }
            out_ += "#if(HF_Camera) ";
            HF_TRY_DONE(copy_camera(at, end));
            out_ += " #end ";
            enter_union(in_macro);
            return end;
        }

        /// Tests for `light_source {`, and for `object {` with the name of a light.
        bool is_light(std::size_t at) const {
            if (token(at).text == "light_source") return true;
            return token(at).text == "object" && declared_light(token(at + 2).text) != nullptr;
        }

        /// Returns the braces of a declared light; null if the name is none.
        const DeclaredValue* declared_light(std::string_view name) const {
            const auto found = wrapper_.values_.find(std::string(name));
            if (found == wrapper_.values_.end()) return nullptr;
            const DeclaredValue& value = found->second;
            const bool is_light = value.begin + 1 < value.source->tokens.size() &&
                                  value.source->tokens[value.begin].is_word("light_source");
            return is_light ? &value : nullptr;
        }

        /// Rewrites a light. In a survey, its properties are evaluated and written.
        Result<std::size_t> light(std::size_t at, std::size_t end) {
            const std::size_t id = add_statement(at, "light_source", "");
            out_ += fmt::format("\n#if(HF_Survey) HF_Light({}) ", id);
            evaluate_light(tokens_, at + 2, end - 1, 0);
            out_ += " HF_Word(\"}\") #end ";
            HF_TRY_DONE(guarded("HF_Lights", at, end));
            return end;
        }

        /// Writes an expression's evaluation: `HF_Number(expression)`. Returns the index behind it.
        std::size_t evaluate(std::string_view macro, std::span<const SceneToken> tokens, std::size_t at) {
            const std::size_t end = end_of_expression(tokens, at);
            if (end == at || tokens[at].kind == Kind::directive) {
                out_ += " HF_Word(\"?\") ";
                return end;
            }
            const std::string_view text(tokens[at].text.data() - (tokens[at].kind == Kind::string),
                                        static_cast<std::size_t>(tokens[end - 1].end - tokens[at].begin));
            constexpr std::array colour_words{"color", "colour", "rgb",   "rgbf", "rgbt",
                                              "rgbft", "red",    "green", "blue", "srgb"};
            const bool is_colour = macro == "HF_Colour";
            const bool is_named = is_colour && !is_one_of(tokens[at].text, colour_words);
            out_ += fmt::format("#declare HF_V={}{}; {}(HF_V) ",
                                macro == "HF_Vector" ? "<0,0,0>+"
                                : is_named           ? "color "
                                                     : "",
                                text, macro);
            return end;
        }

        void evaluate_light(std::span<const SceneToken> all, std::size_t from, std::size_t to, int depth) {
            constexpr std::array flags{"spotlight", "cylinder", "parallel",          "shadowless",
                                       "circular",  "orient",   "area_illumination", "jitter"};
            constexpr std::array numbers{"radius",        "falloff",    "tightness",
                                         "fade_distance", "fade_power", "adaptive"};
            constexpr std::array vectors{"point_at", "translate", "rotate", "scale"};
            constexpr std::array ignored{"media_interaction", "media_attenuation"};
            const std::span<const SceneToken> tokens = all.first(to);
            std::size_t at = from;
            const DeclaredValue* declared = at < to ? declared_light(tokens[at].text) : nullptr;
            if (declared && depth < 8) {
                evaluate_light(declared->source->tokens, declared->begin + 2, declared->end - 1, depth + 1);
                ++at;
            } else {
                at = evaluate("HF_Vector", tokens, at);
                if (at < to && tokens[at].is(',')) ++at;
                at = evaluate("HF_Colour", tokens, at);
            }
            while (at < to) {
                const SceneToken& here = tokens[at];
                if (here.kind == Kind::directive) {
                    std::size_t end = at + 1;
                    if (end < to && tokens[end].is('(')) end = std::max(end, end_of_group(tokens, end));
                    out_ += std::string(here.text.empty() ? "" : " #") + std::string(here.text);
                    if (end > at + 1)
                        out_.append(tokens[at + 1].text.data(), tokens[end - 1].end - tokens[at + 1].begin);
                    out_ += ' ';
                    at = end;
                    continue;
                }
                ++at;
                if (here.is(',')) continue;
                if (is_one_of(here.text, flags)) {
                    const bool is_off = at < to && (tokens[at].is_word("off") || tokens[at].is_word("no"));
                    if (!is_off) out_ += fmt::format(" HF_Word(\"{}\") ", here.text);
                    if (at < to && (is_off || tokens[at].is_word("on") || tokens[at].is_word("yes"))) ++at;
                } else if (is_one_of(here.text, numbers)) {
                    out_ += fmt::format(" HF_Word(\"{}\") ", here.text);
                    at = evaluate("HF_Number", tokens, at);
                } else if (is_one_of(here.text, vectors)) {
                    out_ += fmt::format(" HF_Word(\"{}\") ", here.text);
                    at = evaluate(here.text == "scale" ? "HF_Scale" : "HF_Vector", tokens, at);
                } else if (here.text == "area_light") {
                    out_ += " HF_Word(\"area_light\") ";
                    for (const char* macro : {"HF_Vector", "HF_Vector", "HF_Count", "HF_Count"}) {
                        if (at < to && tokens[at].is(',')) {
                            out_ += " HF_Word(\",\") ";
                            ++at;
                        }
                        at = evaluate(macro, tokens, at);
                    }
                } else if (is_one_of(here.text, ignored)) {
                    at = end_of_expression(tokens, at);
                } else if (at < to && tokens[at].is('{')) {
                    const std::size_t end = end_of_group(tokens, at);
                    if (here.text != "looks_like" && here.text != "photons") out_ += " HF_Word(\"?\") ";
                    if (end == 0) return;
                    at = end;
                } else {
                    out_ += " HF_Word(\"?\") ";
                }
            }
        }

        Wrapper& wrapper_;
        const SourceFile& source_;
        const Tokens& tokens_;
        int include_depth_;
        std::string out_;
    };

    bool is_library(const SourceFile& source) const {
        return std::ranges::any_of(options_.library, [&](const std::filesystem::path& folder) {
            std::error_code ignored;
            return std::filesystem::exists(folder / source.name, ignored);
        });
    }

    std::filesystem::path scene_;
    const WrapOptions& options_;
    WrappedScene result_;
    std::map<std::string, SourceFile> sources_;  ///< By path.
    std::map<std::string, std::string> names_;   ///< Of rewritten files, by path.
    std::set<std::string> macros_, statement_macros_;
    std::map<std::string, DeclaredValue> values_;  ///< Right sides of declarations, by name.
    std::map<std::string, UnusedStatement> unused_;
    std::vector<std::string> unused_order_;
};

}  // namespace

Result<WrappedScene> wrapped_scene(const std::filesystem::path& scene, const WrapOptions& options) {
    return Wrapper(scene, options).wrapped();
}

}  // namespace haarfield
