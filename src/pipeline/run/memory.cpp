#include "pipeline/run/memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

#include "core/log.hpp"

namespace colossus::pipeline::run {
namespace {

namespace fs = std::filesystem;
using core::Status;

constexpr std::uint64_t kNoLimit = ~std::uint64_t{0};

std::optional<std::uint64_t> number_in(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.remove_suffix(1);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::uint64_t limit_in_file(const fs::path& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  // Version 2 says "max", version 1 a number near 2^63.
  return number_in(text).value_or(kNoLimit);
}

// The limits of a group and of those above it, up to where the hierarchy is mounted. In a container the path
// may be that of the host: then only the mount itself is there.
std::uint64_t limit_of_group(const fs::path& mount, const std::string& group, const char* file) {
  std::uint64_t least = limit_in_file(mount / file);
  fs::path at = mount;
  for (const fs::path& part : fs::path(group).relative_path()) {
    at /= part;
    least = std::min(least, limit_in_file(at / file));
  }
  return least;
}

std::uint64_t limit_of_groups(const fs::path& root) {
  std::uint64_t least = kNoLimit;
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    // hierarchy:controllers:path; version 2 has no controllers.
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = fmt::format(",{},", line.substr(first + 1, second - first - 1));
    const std::string group = line.substr(second + 1);
    if (controllers == ",,")
      least = std::min(least, limit_of_group(root / "sys/fs/cgroup", group, "memory.max"));
    else if (controllers.find(",memory,") != std::string::npos)
      least = std::min(least, limit_of_group(root / "sys/fs/cgroup/memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

// Slurm counts in MiB; 0 stands for all memory.
std::uint64_t limit_of_slurm(const Variable& variable) {
  const auto value = [&](const char* name) {
    const auto text = variable(name);
    return text ? number_in(*text).value_or(0) : 0;
  };
  if (const std::uint64_t per_node = value("SLURM_MEM_PER_NODE"); per_node > 0) return per_node << 20;
  const std::uint64_t per_cpu = value("SLURM_MEM_PER_CPU");
  const std::uint64_t cpus = value("SLURM_CPUS_ON_NODE");
  return per_cpu > 0 && cpus > 0 ? per_cpu * cpus << 20 : kNoLimit;
}

std::uint64_t physical_memory() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

std::uint64_t parse_size(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (unit.size() > 1 && (unit.back() == 'B' || unit.back() == 'b')) unit.remove_suffix(1);
  if (unit.size() == 2 && unit.back() == 'i') unit.remove_suffix(1);
  constexpr std::string_view kUnits = "KMGT";
  int power = 0;
  if (unit.size() == 1) {
    const std::size_t found = kUnits.find(static_cast<char>(unit[0] & ~0x20));
    power = found == std::string_view::npos ? -1 : static_cast<int>(found) + 1;
  } else if (!unit.empty()) {
    power = -1;
  }
  const double bytes = std::ldexp(number, 10 * power);
  if (error != std::errc() || power < 0 || !(bytes >= 0.0) || !(bytes < 0x1p60))
    core::fail(Status::kUsage, "'{}' is no size; expected a number with K, M, G or T, such as 512M or 2G",
               text);
  return static_cast<std::uint64_t>(bytes);
}

std::string size_text(std::uint64_t bytes) {
  static constexpr std::array<const char*, 5> kUnits{"B", "kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1024.0 && unit + 1 < kUnits.size(); ++unit) value /= 1024.0;
  return unit == 0 ? fmt::format("{} B", bytes)
                   : fmt::format("{:.1f} {}", std::ceil(value * 10.0) / 10.0, kUnits[unit]);
}

std::uint64_t host_memory(std::uint64_t physical, const fs::path& root, const Variable& variable) {
  return std::min({physical, limit_of_groups(root), limit_of_slurm(variable)});
}

std::uint64_t memory_per_rank(const cluster::Communicator& ranks, const std::optional<std::string>& asked) {
  std::uint64_t mine = 0;
  const std::vector<std::string> hosts = ranks.host_names();
  ranks.attempt([&] {
    if (asked) {
      mine = parse_size(*asked);
      if (mine < kLeastMemory)
        core::fail(Status::kUsage, "--memory {} is too small; the least is {}M", *asked, kLeastMemory >> 20);
      return;
    }
    const auto variable = [](const char* name) -> std::optional<std::string> {
      const char* value = std::getenv(name);
      return value == nullptr ? std::nullopt : std::optional<std::string>(value);
    };
    const auto rank = static_cast<std::size_t>(ranks.rank());
    const auto neighbors = static_cast<std::uint64_t>(std::count(hosts.begin(), hosts.end(), hosts[rank]));
    mine = host_memory(physical_memory(), "/", variable) / neighbors;
  });
  const std::uint64_t least = ranks.min(mine);
  if (least >= kLeastMemory) return least;
  if (ranks.is_root())
    core::warn("a rank's share of its host's memory is {}; the least that builds is {}: start fewer ranks",
               size_text(least), size_text(kLeastMemory));
  return kLeastMemory;
}

void require_memory(const Workspace& workspace, std::uint64_t bytes, const std::string& what) {
  if (bytes + kBaseMemory <= workspace.memory_bytes) return;
  core::fail(
      Status::kNoResources,
      "{} needs some {} of memory, but a rank may use {}: give each rank more with --memory, and start "
      "fewer ranks per host if need be",
      what, size_text(bytes + kBaseMemory), size_text(workspace.memory_bytes));
}

std::uint64_t greatest_peak_memory(const cluster::Communicator& ranks) {
  return ranks.max<std::uint64_t>(core::peak_memory_bytes());
}

}  // namespace colossus::pipeline::run
