#pragma once
/// Changes to files that know what a file is made of: numbers, lines, references, lengths, checksums.

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// How a file is built.
enum class FileKind { text, binary, glb, png };

/// Changes one to some ten numbers, lines, words or references: a number by one, by its sign, by powers of
/// ten up to the ends of floats, or to another number of the file; lines doubled, left out, exchanged, or
/// there many times over; names exchanged. Of binary files words of 16 and 32 bits, counts among them.
/// Lengths of GLB's chunks and PNG's checksums are then put right, most of the time.
void change_structure(std::string& bytes, FuzzRandom& random, FileKind kind);

}  // namespace haarfield
