# Writes the files of a folder as one C++ source: cmake -DFOLDER=... -DOUTPUT=... -P page_files.cmake
file(GLOB names RELATIVE ${FOLDER} ${FOLDER}/*)
list(SORT names)
set(arrays "")
set(entries "")
set(number 0)
foreach(name IN LISTS names)
    file(READ ${FOLDER}/${name} bytes HEX)
    string(LENGTH "${bytes}" digits)
    math(EXPR size "${digits} / 2")
    string(REGEX REPLACE "(..)" "'\\\\x\\1'," bytes "${bytes}")
    string(APPEND arrays "constexpr char file_${number}[] = {${bytes}'\\0'};\n")
    string(APPEND entries "    {\"${name}\", {file_${number}, ${size}}},\n")
    math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT}.new "#include <map>
#include <string_view>

namespace haarfield {
namespace {
${arrays}}  // namespace

extern const std::map<std::string_view, std::string_view> compiled_page_files;
const std::map<std::string_view, std::string_view> compiled_page_files{
${entries}};

}  // namespace haarfield
")
file(COPY_FILE ${OUTPUT}.new ${OUTPUT} ONLY_IF_DIFFERENT)
file(REMOVE ${OUTPUT}.new)
