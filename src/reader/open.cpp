#include "reader/open.hpp"

namespace colossus::reader {

AnyStatue open(const std::filesystem::path& path, const StatueOptions& options) {
  container::ContainerReader container(path);
  if (container.metadata().scheme == container::kSchemeBlocks)
    return std::make_unique<CubeStatue>(std::move(container), options);
  // Says itself that it does not know another scheme.
  return std::make_unique<Statue>(std::move(container), options);
}

}  // namespace colossus::reader
