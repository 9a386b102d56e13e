#include "codec/allocation_count.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> total = 0;

}  // namespace

void* operator new(std::size_t size) {
  total += size;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

// As std::stable_sort asks for memory.
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  total += size;
  return std::malloc(size == 0 ? 1 : size);
}

void operator delete(void* memory) noexcept { std::free(memory); }

void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

namespace colossus {

std::size_t allocated_bytes() { return total; }

}  // namespace colossus
