// Decoded nodes, the least recently used go first. Thread-safe.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "reader/access/statue.hpp"

namespace colossus::reader::access {

template <typename Value>
class NodeCache {
 public:
  explicit NodeCache(std::size_t capacity_bytes) : capacity_bytes_(capacity_bytes) {}

  // The row's node, made by load(); bytes_of(node) is its size. Two threads may load the same node at the
  // same time. Nodes larger than the cache are not kept.
  template <typename Load, typename BytesOf>
  std::shared_ptr<const Value> get(RowIndex row, Load load, BytesOf bytes_of) {
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = entries_.find(row); found != entries_.end()) {
        uses_.splice(uses_.begin(), uses_, found->second.use);
        return found->second.node;
      }
    }
    auto loaded = std::make_shared<const Value>(load());
    const std::size_t bytes = bytes_of(*loaded);
    const std::lock_guard lock(mutex_);
    if (bytes > capacity_bytes_ || entries_.contains(row)) return loaded;
    while (bytes_ + bytes > capacity_bytes_) {
      const auto oldest = entries_.find(uses_.back());
      bytes_ -= oldest->second.bytes;
      entries_.erase(oldest);
      uses_.pop_back();
    }
    uses_.push_front(row);
    entries_[row] = {loaded, bytes, uses_.begin()};
    bytes_ += bytes;
    return loaded;
  }

 private:
  struct Entry {
    std::shared_ptr<const Value> node;
    std::size_t bytes = 0;
    std::list<RowIndex>::iterator use;
  };
  std::size_t capacity_bytes_;
  std::mutex mutex_;  // guards what follows
  std::unordered_map<RowIndex, Entry> entries_;
  std::list<RowIndex> uses_;  // most recent first
  std::size_t bytes_ = 0;
};

}  // namespace colossus::reader::access
