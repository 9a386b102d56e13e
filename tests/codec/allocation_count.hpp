// How many bytes this program has asked operator new for since it started.
#pragma once

#include <cstddef>

namespace colossus {

std::size_t allocated_bytes();

}  // namespace colossus
