// haarfield-pages: writes the manual page and the bash completion of haarfield from the table of options.
// Usage: haarfield-pages DIR    writes DIR/haarfield.1 and DIR/haarfield

#include "fields/file/write_file.h"
#include "tools/command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {
namespace {

constexpr std::string_view summary = "bake light into the vertex colours of POV-Ray meshes";

/// Returns a text for a manual page: no character starts a request or an escape, and hyphens can be copied.
std::string roff(std::string_view text) {
    std::string result;
    bool line_starts = true;
    for (const char c : text) {
        if (line_starts && (c == '.' || c == '\'')) result += "\\&";
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else
            result += c;
        line_starts = c == '\n';
    }
    return result;
}

/// Returns the options of a command and of its option groups.
std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
    std::vector<const CLI::Option*> options = command.get_options([positional](const CLI::Option* option) {
        return !option->get_group().empty() && option->get_positional() == positional;
    });
    for (const CLI::App* group :
         command.get_subcommands([](const CLI::App* app) { return app->get_name().empty(); }))
        for (const CLI::Option* option : options_of(*group, positional)) options.push_back(option);
    return options;
}

/// Returns the entry of one option: its names, its values and its help.
std::string option_entry(const CLI::Option& option, bool positional) {
    return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(option.get_name(positional, !positional)),
                       roff(CLI::Formatter().make_option_opts(&option)), roff(option.get_description()));
}

std::string command_section(const CLI::App& command) {
    std::string operands;
    for (const CLI::Option* option : options_of(command, true))
        operands += " " + CLI::Formatter().make_option_usage(option);
    std::string text = fmt::format(".SS {0}\n\\fBhaarfield {0}\\fR [options]{1}\n.PP\n{2}.\n",
                                   command.get_name(), roff(operands), roff(command.get_description()));
    for (const bool positional : {true, false})
        for (const CLI::Option* option : options_of(command, positional))
            text += option_entry(*option, positional);
    return text + fmt::format(".PP\n.nf\n{}\n.fi\n", roff(command.get_footer()));
}

std::string manual_page(const std::vector<Command>& commands) {
    std::string text = fmt::format(
        ".TH HAARFIELD 1 \"\" \"haarfield {}\" \"User Commands\"\n.SH NAME\nhaarfield \\- {}\n.SH SYNOPSIS\n"
        ".B haarfield\n.I command\n[options]\n.br\n.B haarfield\n[\\-\\-help | \\-\\-version]\n.SH "
        "COMMANDS\n",
        HAARFIELD_VERSION, summary);
    for (const Command& command : commands) text += command_section(*command.app);
    return text +
           ".SH EXIT STATUS\n"
           "0 done, 1 bad input or failed work, 2 bad usage, 3 images differ more than allowed, 130 "
           "interrupted.\n"
           ".SH ENVIRONMENT\n"
           ".TP\n"
           ".B HAARFIELD_READER\n"
           "The program that reads untrusted files; by default haarfield\\-reader, next to haarfield. "
           "Empty: such files are rejected.\n"
           ".SH SEE ALSO\n"
           ".BR povray (1)\n";
}

/// Returns the values of an option that accepts a few words, from its type: `FORMAT:{ply,glb,csv}`.
std::string choices_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const std::size_t start = type.find('{'), end = type.find('}');
    if (start == std::string::npos || end == std::string::npos) return {};
    std::string words = type.substr(start + 1, end - start - 1);
    std::ranges::replace(words, ',', ' ');
    return words;
}

std::string bash_completion(const std::vector<Command>& commands) {
    std::string names, choices, options;
    for (const Command& command : commands) {
        const std::string& name = command.app->get_name();
        names += (names.empty() ? "" : " ") + name;
        std::string words;
        for (const CLI::Option* option : options_of(*command.app, false)) {
            std::string patterns;
            for (const std::string& spelling : option->get_snames())
                patterns += fmt::format("'{} -{}'|", name, spelling);
            for (const std::string& spelling : option->get_lnames()) {
                words += (words.empty() ? "--" : " --") + spelling;
                patterns += fmt::format("'{} --{}'|", name, spelling);
            }
            patterns.pop_back();
            if (const std::string values = choices_of(*option); !values.empty())
                choices += fmt::format("        {}) words='{}' ;;\n", patterns, values);
        }
        options += fmt::format("            {}) words='{}' ;;\n", name, words);
    }
    return fmt::format(R"(# bash completion of haarfield
_haarfield() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} command=${{COMP_WORDS[1]}} words=
    case "$command ${{COMP_WORDS[COMP_CWORD - 1]}}" in
{}    esac
    if ((COMP_CWORD == 1)); then
        words='{} --help --version'
    elif [[ ! $words && $word == -* ]]; then
        case $command in
{}        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o bashdefault -o default -F _haarfield haarfield
)",
                       choices, names, options);
}

int write_pages(const std::filesystem::path& folder) {
    CLI::App program{"", "haarfield"};
    CommonOptions common;
    const std::vector<Command> commands = all_commands(program, common);
    for (const auto& [name, text] :
         {std::pair("haarfield.1", manual_page(commands)), std::pair("haarfield", bash_completion(commands))})
        if (const Result<Done> written = write_file(folder / name, text); !written) {
            fmt::print(stderr, "haarfield-pages: {}\n", written.error().message());
            return 1;
        }
    return 0;
}

}  // namespace
}  // namespace haarfield

int main(int count, char** arguments) {
    if (count == 2) return haarfield::write_pages(arguments[1]);
    std::fputs("Usage: haarfield-pages DIR\n", stderr);
    return 2;
}
