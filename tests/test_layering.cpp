#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

// A folder may include itself and the folders before it in this list. Tests may include everything.
constexpr std::array folders{"fields", "shading", "scenes", "bridge", "tools"};

// The same holds for the rooms of a folder. All sources of a folder with rooms are in rooms, except its
// manual.
const std::map<std::string, std::vector<std::string>> rooms_of{
    {"fields",
     {"base", "file", "mesh", "model", "occluder", "preparation", "wavelets", "rasterizer", "vdb", "field"}},
    {"shading", {"walk", "scene", "visibility", "bounces", "bake", "transfer"}},
    {"bridge", {"povray", "povray_import", "pictures", "files"}},
};

// Libraries that only some files may include, and these files.
const std::map<std::string, std::set<std::string>> only_known_to{
    {"openvdb/", {"fields/vdb/vdb_archive.h"}},
    {"CGAL/",
     {"fields/preparation/mesh_preparation.cpp", "fields/preparation/mesh_simplification.cpp",
      "fields/preparation/opaque_outline.cpp"}},
    {"assimp/",
     {"fields/model/assimp_content.cpp", "fields/model/assimp_model.cpp", "fields/model/assimp_materials.cpp",
      "fields/model/assimp_materials.h", "fields/model/obj_listing.cpp"}},
    {"embree3/", {"fields/base/embree_rays.h"}},
    {"embree4/", {"fields/base/embree_rays.h"}},
    {"toml++/", {"scenes/toml_table.h"}},
    {"OpenImageIO/", {"scenes/image_reader.cpp"}},
    {"Imf", {"scenes/image_encoding.cpp"}},
    {"png.h", {"scenes/image_encoding.cpp"}},
    {"boost/", {"tools/view/view_server.cpp"}},
};

struct Include {
    std::string file;      // relative to the project's root
    std::string included;  // as written
    bool quoted;
};

std::vector<Include> includes_of(const std::string& file, std::istream& text) {
    static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
    std::vector<Include> includes;
    for (std::string line; std::getline(text, line);) {
        std::smatch match;
        if (std::regex_search(line, match, pattern)) includes.push_back({file, match[2], match[1] == "\""});
    }
    return includes;
}

std::vector<Include> project_includes() {
    const std::filesystem::path root = HAARFIELD_SOURCE_DIR;
    std::vector<Include> includes;
    for (const std::string folder : folders)
        for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
            const std::filesystem::path& path = entry.path();
            if (path.extension() != ".h" && path.extension() != ".cpp") continue;
            if (path.parent_path().filename() == "examples") continue;  // programs of users
            std::ifstream text(path);
            const auto found = includes_of(path.lexically_relative(root).generic_string(), text);
            includes.insert(includes.end(), found.begin(), found.end());
        }
    return includes;
}

// True if a path is the manual of a library: the header with the name of its folder.
bool is_door(const std::string& path) {
    const std::filesystem::path parts(path);
    return parts.extension() == ".h" && parts.parent_path() == parts.stem();
}

// Returns the index of a path's folder in `folders`, or their number if it is in none.
std::size_t layer(const std::string& path) {
    const std::string folder = path.substr(0, path.find('/'));
    return static_cast<std::size_t>(std::ranges::find(folders, folder) - folders.begin());
}

// Returns the index of a path's room in its folder; none if it is in no room.
std::optional<std::size_t> room(const std::string& path) {
    const std::filesystem::path parts(path);
    auto part = parts.begin();
    const auto folder = rooms_of.find(part->string());
    if (folder == rooms_of.end()) return std::nullopt;
    const auto found = std::ranges::find(folder->second, (++part)->string());
    if (found == folder->second.end()) return std::nullopt;
    return found - folder->second.begin();
}

// Returns the defect of an include; empty if there is none.
std::string objection(const Include& include) {
    const std::size_t from = layer(include.file), to = layer(include.included);
    if (include.quoted && to >= folders.size())
        return fmt::format("{} includes \"{}\", which names no folder of the project", include.file,
                           include.included);
    if (include.quoted && to > from)
        return fmt::format("{} includes \"{}\", which is above it", include.file, include.included);
    if (include.quoted && is_door(include.included) && !is_door(include.file))
        return fmt::format("{} includes \"{}\", which is for users", include.file, include.included);
    if (include.quoted && from == to && rooms_of.contains(folders[from]) && !is_door(include.file)) {
        const auto from_room = room(include.file), to_room = room(include.included);
        if (!from_room || !to_room)
            return fmt::format("{} includes \"{}\"; wanted both in rooms of {}", include.file,
                               include.included, folders[from]);
        if (*to_room > *from_room)
            return fmt::format("{} includes \"{}\", whose room is above its own", include.file,
                               include.included);
    }
    if (!include.quoted && to < folders.size())
        return fmt::format("{} includes <{}>; wanted quotes", include.file, include.included);
    for (const auto& [library, files] : only_known_to)
        if (include.included.starts_with(library) && !files.contains(include.file))
            return fmt::format("{} includes <{}>, which {} alone may", include.file, include.included,
                               fmt::join(files, " and "));
    return {};
}

TEST(Layering, IncludesPointDownwardsOnly) {
    const std::vector<Include> includes = project_includes();
    EXPECT_GT(includes.size(), 200u);
    for (const Include& include : includes) EXPECT_EQ(objection(include), "");
}

TEST(Layering, ObjectsToIncludesThatPointUpwardsOrAcross) {
    EXPECT_EQ(objection({"tools/bake.cpp", "fields/mesh/mesh.h", true}), "");
    EXPECT_EQ(objection({"fields/mesh/mesh.h", "fields/base/vector.h", true}), "");
    EXPECT_EQ(objection({"fields/mesh/mesh.h", "vector", false}), "");
    EXPECT_NE(objection({"fields/mesh/mesh.h", "shading/scene/sky.h", true}), "");
    EXPECT_NE(objection({"fields/mesh/mesh.h", "fields/field/samplers.h", true}), "");
    EXPECT_EQ(objection({"fields/field/samplers.h", "fields/mesh/mesh.h", true}), "");
    EXPECT_NE(objection({"fields/mesh/mesh.h", "fields/samplers.h", true}), "");
    EXPECT_NE(objection({"fields/attic/old.h", "fields/base/vector.h", true}), "");
    EXPECT_EQ(objection({"bridge/pictures/oracle_check.h", "bridge/povray/reference_picture.h", true}), "");
    EXPECT_NE(objection({"bridge/povray/baked_scene.cpp", "bridge/files/glb_file.h", true}), "");
    EXPECT_NE(objection({"fields/occluder/occluder.h", "fields/preparation/local_samples.h", true}), "");
    EXPECT_NE(objection({"shading/bake/renderer.h", "shading/transfer/relight_session.h", true}), "");
    EXPECT_NE(objection({"shading/scene/sky.h", "scenes/scene.h", true}), "");
    EXPECT_NE(objection({"scenes/scene.h", "bridge/pictures/preview.h", true}), "");
    EXPECT_NE(objection({"bridge/pictures/preview.h", "tools/command.h", true}), "");
    EXPECT_NE(objection({"bridge/pictures/preview.h", "light_dome.h", true}), "");
    EXPECT_NE(objection({"bridge/pictures/preview.h", "fields/mesh/mesh.h", false}), "");
    EXPECT_EQ(objection({"shading/shading.h", "shading/scene/sky.h", true}), "");
    EXPECT_EQ(objection({"shading/shading.h", "fields/fields.h", true}), "");
    EXPECT_NE(objection({"fields/fields.h", "shading/shading.h", true}), "");
    EXPECT_NE(objection({"shading/scene/sky.h", "fields/fields.h", true}), "");
    EXPECT_NE(objection({"tools/bake.cpp", "bridge/bridge.h", true}), "");
    EXPECT_NE(objection({"fields/mesh/mesh.cpp", "openvdb/openvdb.h", false}), "");
    EXPECT_EQ(objection({"fields/base/embree_rays.h", "embree4/rtcore.h", false}), "");
    EXPECT_NE(objection({"bridge/pictures/preview.cpp", "embree3/rtcore.h", false}), "");
    EXPECT_NE(objection({"bridge/files/movie.cpp", "CGAL/Surface_mesh.h", false}), "");
}

TEST(Layering, LibrariesStayInTheirFiles) {
    std::set<std::pair<std::string, std::string>> used;
    for (const Include& include : project_includes())
        for (const auto& [library, files] : only_known_to)
            if (include.included.starts_with(library)) used.insert({library, include.file});
    for (const auto& [library, files] : only_known_to)
        for (const std::string& file : files)
            EXPECT_TRUE(used.contains({library, file}))
                << file << " does not include " << library << ": the rule is void";
}

// Users get the standard headers and those of Imath, which defines the vectors, but no internal headers.
TEST(Layering, ManualsIncludeNoOtherLibraryAndNoInternalHeaders) {
    std::map<std::string, std::vector<Include>> includes;
    for (const Include& include : project_includes()) includes[include.file].push_back(include);
    for (const std::string library : {"fields", "shading", "scenes", "bridge"}) {
        std::vector<std::string> waiting{library + "/" + library + ".h"};
        std::map<std::string, std::string> by{{waiting[0], ""}};
        while (!waiting.empty()) {
            const std::string header = waiting.back();
            waiting.pop_back();
            EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(HAARFIELD_SOURCE_DIR) / header))
                << header << ", included by " << by[header];
            EXPECT_FALSE(header.ends_with("-inl.h")) << header << ", included by " << by[header];
            for (const Include& include : includes[header]) {
                if (include.quoted) {
                    if (by.emplace(include.included, header).second) waiting.push_back(include.included);
                } else {
                    EXPECT_TRUE(include.included.starts_with("Imath/") ||
                                include.included.find_first_of("/.") == std::string::npos)
                        << header << " includes <" << include.included << ">";
                }
            }
        }
        EXPECT_GT(by.size(), 10u) << library;
    }
}

// Returns the files and rooms that a page names in backticks: lower case, with a slash or an extension.
std::set<std::string> files_named_in(const std::filesystem::path& page) {
    static const std::regex name("`([a-z_0-9]+(/[a-z_0-9]*)*(\\.[a-z]+)?)`");
    std::ifstream file(page);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    std::set<std::string> names;
    for (std::sregex_iterator found(text.begin(), text.end(), name), end; found != end; ++found)
        if (found->str(1).find_first_of("/.") != std::string::npos) names.insert(found->str(1));
    return names;
}

TEST(Layering, FolderPagesNameWhatIsThere) {
    const std::filesystem::path root = HAARFIELD_SOURCE_DIR;
    for (const std::string folder : {"fields", "shading", "scenes", "bridge", "tools", "tests"}) {
        const std::set<std::string> named = files_named_in(root / folder / "README.md");
        EXPECT_GT(named.size(), 5u) << folder;
        for (const std::string& name : named)
            EXPECT_TRUE(name.starts_with("build/") || exists(root / folder / name) || exists(root / name))
                << folder << "/README.md names " << name;
        // All rooms; where there are none, all headers.
        for (const auto& entry : std::filesystem::directory_iterator(root / folder)) {
            const std::string name = entry.path().filename().string();
            if (!entry.is_directory() && !name.ends_with(".h")) continue;
            EXPECT_TRUE(named.contains(entry.is_directory() ? name + "/" : name))
                << folder << "/README.md lacks " << name;
        }
    }
}

TEST(Layering, FindsIncludesHoweverTheyAreSpaced) {
    std::istringstream text(
        "#include \"a/b.h\"\n  #  include <c>\n#include<d.h> // why\n// #include \"e\"\nint x;\n");
    const std::vector<Include> found = includes_of("f", text);
    ASSERT_EQ(found.size(), 3u);
    EXPECT_EQ(found[0].included, "a/b.h");
    EXPECT_TRUE(found[0].quoted);
    EXPECT_EQ(found[1].included, "c");
    EXPECT_FALSE(found[1].quoted);
    EXPECT_EQ(found[2].included, "d.h");
}

}  // namespace
