#include "fields/mesh_text.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

namespace haarfield {
namespace {

/// The text outlives the streams over it, as assimp closes them before it lets go of the system.
class ObjIoSystem : public Assimp::DefaultIOSystem {
public:
    ObjIoSystem(const std::filesystem::path& file, std::string text)
        : file_(file.string()), text_(std::move(text)) {}

    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (file_ == name && mode[0] == 'r')
            return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()),
                                              text_.size());
        return DefaultIOSystem::Open(name, mode);
    }

private:
    std::string file_, text_;
};

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

std::string with_leading_zeros(const std::string& text) {
    std::string result;
    result.reserve(text.size() + text.size() / 16);
    bool coordinates = false;  // in a line that begins with v, vt, vn ...
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (i == 0 || text[i - 1] == '\n') coordinates = text[i] == 'v';
        const char before = i == 0 ? '\n' : text[i - 1];
        const bool begins = std::isspace(static_cast<unsigned char>(before)) ||
                            ((before == '-' || before == '+') &&
                             (i < 2 || std::isspace(static_cast<unsigned char>(text[i - 2]))));
        if (coordinates && text[i] == '.' && begins && i + 1 < text.size() && is_digit(text[i + 1]))
            result += '0';
        result += text[i];
    }
    return result;
}

std::unique_ptr<Assimp::IOSystem> obj_with_leading_zeros(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (ending != ".obj") return std::make_unique<Assimp::DefaultIOSystem>();
    std::ifstream stream(file, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    std::string mended = with_leading_zeros(text);
    if (!stream || mended == text) return std::make_unique<Assimp::DefaultIOSystem>();
    return std::make_unique<ObjIoSystem>(file, std::move(mended));
}

}  // namespace haarfield
