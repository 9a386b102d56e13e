#include "core/version.hpp"

namespace colossus::core {

const char* release_version() { return COLOSSUS_VERSION; }

}  // namespace colossus::core
