// The readers behind open_source(), one per format. All share its contract.
#pragma once

#include <memory>

#include "core/file.hpp"
#include "input/source.hpp"

namespace colossus::input {

// `file` is open for reading and not empty.
std::unique_ptr<Source> open_ply(core::File file, const SourceOptions& options);
std::unique_ptr<Source> open_obj(core::File file, const SourceOptions& options);
std::unique_ptr<Source> open_binary_stl(core::File file, const SourceOptions& options);
std::unique_ptr<Source> open_ascii_stl(core::File file, const SourceOptions& options);
// How many triangles the header of a binary STL tells of; 0 for what is too short for one.
std::uint64_t binary_stl_count(const core::File& file);
// Of a binary STL with so many triangles.
std::uint64_t binary_stl_bytes(std::uint64_t triangles);
std::unique_ptr<Source> open_off(core::File file, const SourceOptions& options);

enum class FileFormat { kPly, kObj, kOff, kBinaryStl, kAsciiStl };
// By content, then by extension. Throws Error(kBadData) for an empty file, for what is neither, and, saying
// what it is, for what is packed, UTF-16, or only stands for a file.
FileFormat detect_format(const core::File& file);

// Throws Error(kBadData) when info.textures is not empty and the options do not drop them.
void refuse_textures(const SourceInfo& info, const SourceOptions& options);

// Throws Error(kBadData) when the count is 0, or too large for 32-bit indices.
void check_vertex_count(const SourceInfo& info, std::uint64_t count);

}  // namespace colossus::input
