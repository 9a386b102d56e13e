// Any bytes, from seeds that are STL files; see fuzz_input.hpp.
#include "fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  colossus::fuzz::read_input(data, size);
  return 0;
}
