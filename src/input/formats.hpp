// The readers behind open_source(), one per format. All share its contract.
#pragma once

#include <memory>

#include "core/file.hpp"
#include "input/source.hpp"

namespace colossus::input {

// `file` is open for reading and not empty.
std::unique_ptr<Source> open_ply(core::File file, const SourceOptions& options);
std::unique_ptr<Source> open_obj(core::File file, const SourceOptions& options);
std::unique_ptr<Source> open_stl(core::File file);
std::unique_ptr<Source> open_off(core::File file, const SourceOptions& options);

// A binary STL has exactly the size that its triangle count says; "solid" at its start says nothing.
bool is_binary_stl(const core::File& file);

// Throws Error(kBadData) when info.textures is not empty and the options do not drop them.
void refuse_textures(const SourceInfo& info, const SourceOptions& options);

// Throws Error(kBadData) when the count is 0, or too large for 32-bit indices.
void check_vertex_count(const SourceInfo& info, std::uint64_t count);

}  // namespace colossus::input
