// Which release of this program it is.
#pragma once

namespace colossus::core {

// Such as "0.1.0".
const char* release_version();

}  // namespace colossus::core
