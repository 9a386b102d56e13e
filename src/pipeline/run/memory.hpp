// How much memory a rank may use, and what is too large for it.
//
// The limit decides nothing but whether a build goes on: buffers and tasks have sizes of their own, which fit
// into the least limit, and what the input makes larger is refused when it does not fit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "pipeline/run/workspace.hpp"

namespace colossus::pipeline::run {

inline constexpr std::uint64_t kLeastMemory = std::uint64_t{256} << 20;

// The program, MPI's buffers, and what the allocator keeps back: not available to a task.
inline constexpr std::uint64_t kBaseMemory = std::uint64_t{96} << 20;

// A number with an optional K, M, G or T (powers of 1024), such as 512M or 1.5G; iB or B may follow. Throws
// Error(kUsage).
std::uint64_t parse_size(std::string_view text);
// With one decimal and a unit, rounded up.
std::string size_text(std::uint64_t bytes);

// What this host grants to the ranks on it together: the least of the physical memory, the limits of the
// process's control groups (both versions, with those above them), and SLURM_MEM_PER_NODE or
// SLURM_MEM_PER_CPU. `root` and `variable` are for tests. Not collective.
using Variable = std::function<std::optional<std::string>(const char* name)>;
std::uint64_t host_memory(std::uint64_t physical, const std::filesystem::path& root,
                          const Variable& variable);

// The limit per rank: what the user asks for, or else the least share of a rank in its host's memory, but not
// less than kLeastMemory, with a warning. Throws Error(kUsage) for less than that from the user. Collective.
std::uint64_t memory_per_rank(const cluster::Communicator& ranks, const std::optional<std::string>& asked);

// Throws Error(kNoResources) when a task that needs `bytes` does not fit beside kBaseMemory. `what` begins
// the message: what is so large, and where.
void require_memory(const Workspace& workspace, std::uint64_t bytes, const std::string& what);

// The greatest resident set of any rank so far. Collective.
std::uint64_t greatest_peak_memory(const cluster::Communicator& ranks);

}  // namespace colossus::pipeline::run
