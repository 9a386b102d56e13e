#include "reader/open.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace colossus::reader {

std::unique_ptr<access::Statue> open(const std::filesystem::path& path,
                                     const access::StatueOptions& options) {
  container::ContainerReader container(path);
  const std::string& name = container.metadata().scheme;
  const auto all = schemes();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Scheme& s) { return s.name == name; });
  if (found != all.end()) return found->open(std::move(container), options);
  std::string names;
  for (const Scheme& scheme : all) names += fmt::format("{}'{}'", names.empty() ? "" : " or ", scheme.name);
  core::fail(core::Status::kBadData, "{}: scheme: expected {}, found '{}'", path.string(), names, name);
}

}  // namespace colossus::reader
