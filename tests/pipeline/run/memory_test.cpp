// How much memory a rank may use: made-up hosts with control groups and Slurm.
#include "pipeline/run/memory.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <random>

#include "support/temporary_directory.hpp"

namespace colossus::pipeline::run {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kPhysical = 64 * 1024 * kMiB;

// A host's /proc and /sys below a folder, and its environment.
class MadeUpHost {
 public:
  void write(const std::string& path, const std::string& text) {
    const auto file = root_.path() / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void set(const std::string& name, const std::string& value) { variables_[name] = value; }
  std::uint64_t memory() const {
    return host_memory(kPhysical, root_.path(), [&](const char* name) -> std::optional<std::string> {
      const auto found = variables_.find(name);
      return found == variables_.end() ? std::nullopt : std::optional(found->second);
    });
  }

 private:
  support::TemporaryDirectory root_;
  std::map<std::string, std::string> variables_;
};

bool is_size(const std::string& text) {
  try {
    parse_size(text);
    return true;
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kUsage) << text;
    EXPECT_NE(std::string(error.what()).find("'" + text + "'"), std::string::npos) << error.what();
    return false;
  }
}

TEST(ParseSize, TakesEveryUnitInEveryWriting) {
  const std::map<std::string, int> powers{{"", 0}, {"k", 10}, {"m", 20}, {"g", 30}, {"t", 40}};
  for (const auto& [unit, power] : powers)
    for (const std::string number : {"0", "1", "7", "512", "1000"})
      for (const std::string ending : {"", "b", "B", "ib", "iB"}) {
        if (unit.empty() && !ending.empty()) continue;
        std::string upper = unit;
        for (char& c : upper) c = static_cast<char>(std::toupper(c));
        const std::uint64_t expected = std::stoull(number) << power;
        EXPECT_EQ(parse_size(number + unit + ending), expected) << number << unit << ending;
        EXPECT_EQ(parse_size(number + upper + ending), expected) << number << upper << ending;
      }
  EXPECT_EQ(parse_size("1.5G"), 1536 * kMiB);
  EXPECT_EQ(parse_size("0.5k"), 512U);
  EXPECT_EQ(parse_size("1e3"), 1000U);
}

TEST(ParseSize, RefusesWhatIsNoSize) {
  for (const std::string word : {"", "G", "M512", "-1", "-1G", "1X", "1GG", "1 G", "1iB", "1GiBs", "nan",
                                 "inf", "1e30", "2000000T", " 1", "1,5G", "0x10", "+1"})
    EXPECT_FALSE(is_size(word)) << word;
}

TEST(SizeText, RoundsUpToOneDecimal) {
  EXPECT_EQ(size_text(0), "0 B");
  EXPECT_EQ(size_text(1023), "1023 B");
  EXPECT_EQ(size_text(1024), "1.0 kB");
  EXPECT_EQ(size_text(1025), "1.1 kB");
  EXPECT_EQ(size_text(kMiB), "1.0 MB");
  EXPECT_EQ(size_text(kMiB + 1), "1.1 MB");
  EXPECT_EQ(size_text(3 * 512 * kMiB), "1.5 GB");
  EXPECT_EQ(size_text(std::uint64_t{1} << 52), "4096.0 TB");
}

// Otherwise the size that a message names would not be enough.
TEST(SizeText, IsNeverLessThanTheSize) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t bytes = random() >> (5 + random() % 58);
    std::string text = size_text(bytes);
    text.erase(text.find(' '), 1);
    const std::uint64_t read =
        parse_size(text.size() > 1 && text[text.size() - 2] >= '0' && text[text.size() - 2] <= '9'
                       ? text.substr(0, text.size() - 1)
                       : text);
    EXPECT_GE(read + 1, bytes) << text;
    EXPECT_LE(static_cast<double>(read), 1.101 * static_cast<double>(bytes)) << text;
  }
}

TEST(HostMemory, IsPhysicalWhereNothingLimits) {
  MadeUpHost host;
  EXPECT_EQ(host.memory(), kPhysical);
  host.write("proc/self/cgroup", "0::/\n");
  EXPECT_EQ(host.memory(), kPhysical);
  host.write("sys/fs/cgroup/memory.max", "max\n");
  EXPECT_EQ(host.memory(), kPhysical);
  host.write("sys/fs/cgroup/memory.max", fmt::format("{}\n", 2 * kPhysical));
  EXPECT_EQ(host.memory(), kPhysical);
}

TEST(HostMemory, IsTheLeastOfNestedGroupsOfVersion2) {
  const std::vector<std::string> folders{"", "system.slice/", "system.slice/batch.scope/",
                                         "system.slice/batch.scope/job_7/"};
  std::mt19937_64 random(2);
  for (int i = 0; i < 50; ++i) {
    MadeUpHost host;
    host.write("proc/self/cgroup", "0::/system.slice/batch.scope/job_7\n");
    std::uint64_t least = kPhysical;
    for (const std::string& folder : folders) {
      const std::uint64_t limit = (1 + random() % 100'000) * kMiB;
      const auto kind = random() % 3;  // no file, no limit, a limit
      if (kind > 0)
        host.write("sys/fs/cgroup/" + folder + "memory.max",
                   kind == 1 ? "max\n" : fmt::format("{}\n", limit));
      if (kind == 2) least = std::min(least, limit);
    }
    // A sibling's limit is none of ours.
    host.write("sys/fs/cgroup/system.slice/other.scope/memory.max", "1048576\n");
    EXPECT_EQ(host.memory(), least);
  }
}

TEST(HostMemory, IsTheLeastOfNestedGroupsOfVersion1) {
  MadeUpHost host;
  const std::string mount = "sys/fs/cgroup/memory/";
  host.write("proc/self/cgroup",
             "12:cpuset:/other\n5:hugetlb,memory,rdma:/slurm/uid_0/job_7\n1:name=systemd:/user.slice\n");
  host.write("sys/fs/cgroup/memory.max", "1048576\n");             // of no group of this process
  host.write(mount + "other/memory.limit_in_bytes", "1048576\n");  // that of another controller
  host.write(mount + "memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_EQ(host.memory(), kPhysical);
  host.write(mount + "slurm/uid_0/job_7/memory.limit_in_bytes", fmt::format("{}\n", 3000 * kMiB));
  EXPECT_EQ(host.memory(), 3000 * kMiB);
  host.write(mount + "slurm/memory.limit_in_bytes", fmt::format("{}\n", 2000 * kMiB));
  EXPECT_EQ(host.memory(), 2000 * kMiB);
}

TEST(HostMemory, IsTheLeastOfBothVersionsSideBySide) {
  for (const bool is_first_less : {false, true}) {
    MadeUpHost host;
    host.write("proc/self/cgroup", "4:memory:/a\n0::/b\n");
    host.write("sys/fs/cgroup/memory/a/memory.limit_in_bytes",
               fmt::format("{}", (is_first_less ? 1 : 2) * 1024 * kMiB));
    host.write("sys/fs/cgroup/b/memory.max", fmt::format("{}", (is_first_less ? 2 : 1) * 1024 * kMiB));
    EXPECT_EQ(host.memory(), 1024 * kMiB);
  }
}

// In a container the path may be that of the host: the group is mounted as the root then.
TEST(HostMemory, IsThatOfTheMountWhereThePathIsTheHosts) {
  MadeUpHost host;
  host.write("proc/self/cgroup", "0::/docker/4711\n");
  host.write("sys/fs/cgroup/memory.max", fmt::format("{}\n", 512 * kMiB));
  EXPECT_EQ(host.memory(), 512 * kMiB);
}

TEST(HostMemory, GroupsMayHaveColonsInTheirNamesAndLinesMayBeNone) {
  MadeUpHost host;
  host.write("proc/self/cgroup", "nonsense\n0:half\n0::/a:b\n");
  host.write("sys/fs/cgroup/a:b/memory.max", fmt::format("{}\n", 700 * kMiB));
  EXPECT_EQ(host.memory(), 700 * kMiB);
}

TEST(HostMemory, IsWhatSlurmGrants) {
  MadeUpHost host;
  host.set("SLURM_MEM_PER_CPU", "1000");
  EXPECT_EQ(host.memory(), kPhysical) << "of how many processors is not known";
  host.set("SLURM_CPUS_ON_NODE", "3");
  EXPECT_EQ(host.memory(), 3000 * kMiB);
  host.set("SLURM_MEM_PER_NODE", "5000");
  EXPECT_EQ(host.memory(), 5000 * kMiB) << "the node's comes first";
  host.set("SLURM_MEM_PER_NODE", "0");
  EXPECT_EQ(host.memory(), 3000 * kMiB) << "0 is all memory";
  host.set("SLURM_MEM_PER_CPU", "0");
  EXPECT_EQ(host.memory(), kPhysical);
  host.set("SLURM_MEM_PER_NODE", "lots");
  EXPECT_EQ(host.memory(), kPhysical);
  host.set("SLURM_MEM_PER_NODE", "5000");
  host.write("proc/self/cgroup", "0::/\n");
  host.write("sys/fs/cgroup/memory.max", fmt::format("{}\n", 4000 * kMiB));
  EXPECT_EQ(host.memory(), 4000 * kMiB) << "the group's is less";
}

}  // namespace
}  // namespace colossus::pipeline::run
