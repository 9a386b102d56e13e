#include "reader/open.hpp"

namespace colossus::reader {

AnyStatue open(const std::filesystem::path& path, const access::StatueOptions& options) {
  container::ContainerReader container(path);
  if (container.metadata().scheme == container::kSchemeBlocks)
    return std::make_unique<blocks::CubeStatue>(std::move(container), options);
  // Says itself that it does not know another scheme.
  return std::make_unique<diamonds::Statue>(std::move(container), options);
}

}  // namespace colossus::reader
