#pragma once
/// Changes to files that respect their structure: numbers, lines, references, lengths, checksums.

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// The structure of a file.
enum class FileKind { text, binary, glb, png };

/// Changes one to about ten numbers, lines, words or references. A number changes by one, by its sign, by
/// powers of ten up to the limits of floats, or to another number of the file. Lines are duplicated, removed,
/// swapped or repeated many times, and names are swapped. In binary files, changes 16 and 32 bit words,
/// including counts. Then usually corrects the lengths of GLB chunks and the checksums of PNG.
void change_structure(std::string& bytes, FuzzRandom& random, FileKind kind);

}  // namespace haarfield
