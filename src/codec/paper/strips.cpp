#include "codec/paper/strips.hpp"

#include <algorithm>
#include <array>

namespace colossus::codec::paper {
namespace {

using mesh::Triangle;

constexpr std::uint32_t kNone = ~std::uint32_t{0};

bool names_a_vertex_twice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// The triangle of a window, and the window of a triangle: its own inverse.
Triangle exchanged(const Triangle& t, bool is_odd) { return is_odd ? Triangle{t[1], t[0], t[2]} : t; }

// For the side from corner c / 3, c % 3 to the next one the corner at which the triangle across begins the
// same side in the other direction. Sides in excess, of edges of more than two triangles, have none.
std::vector<std::uint32_t> sides_across(std::span<const Triangle> triangles, std::size_t vertex_count) {
  struct Side {
    std::uint32_t greater_end;
    bool is_forward;
    std::uint32_t corner;
  };
  const auto side_of = [&](std::uint32_t corner) {
    const Triangle& t = triangles[corner / 3];
    return std::array{t[corner % 3], t[(corner + 1) % 3]};
  };
  // Dealt out by the lesser end, then sorted within these small groups.
  const auto corner_count = static_cast<std::uint32_t>(3 * triangles.size());
  std::vector<std::uint32_t> starts(vertex_count + 1, 0);
  for (std::uint32_t c = 0; c < corner_count; ++c) {
    const auto [a, b] = side_of(c);
    ++starts[std::min(a, b) + 1];
  }
  for (std::size_t v = 0; v < vertex_count; ++v) starts[v + 1] += starts[v];
  std::vector<Side> sides(corner_count);
  std::vector<std::uint32_t> cursor(starts.begin(), starts.end() - 1);
  for (std::uint32_t c = 0; c < corner_count; ++c) {
    const auto [a, b] = side_of(c);
    sides[cursor[std::min(a, b)]++] = {std::max(a, b), a < b, c};
  }
  std::vector<std::uint32_t> across(corner_count, kNone);
  std::vector<std::uint32_t> waiting;  // sides of one edge, all in one direction
  for (std::size_t v = 0; v < vertex_count; ++v) {
    const auto group = std::span(sides).subspan(starts[v], starts[v + 1] - starts[v]);
    std::sort(group.begin(), group.end(), [](const Side& l, const Side& r) {
      return l.greater_end != r.greater_end ? l.greater_end < r.greater_end : l.corner < r.corner;
    });
    for (std::size_t i = 0; i < group.size(); ++i) {
      if (i == 0 || group[i].greater_end != group[i - 1].greater_end) waiting.clear();
      if (waiting.empty() || side_of(waiting.back()) == side_of(group[i].corner)) {
        waiting.push_back(group[i].corner);
      } else {
        across[group[i].corner] = waiting.back();
        across[waiting.back()] = group[i].corner;
        waiting.pop_back();
      }
    }
  }
  return across;
}

// A cache of vertices, first in, first out.
class VertexCache {
 public:
  explicit VertexCache(std::size_t vertex_count) : entered_(vertex_count, 0) {}
  static constexpr std::uint32_t kSize = 16;

  bool holds(std::uint32_t vertex) const { return entered_[vertex] + kSize > misses_; }
  void use(std::uint32_t vertex) {
    if (!holds(vertex)) entered_[vertex] = ++misses_;
  }
  std::uint32_t misses() const { return misses_ - kSize; }

 private:
  std::vector<std::uint32_t> entered_;  // number of the miss
  std::uint32_t misses_ = kSize;
};

class StripBuilder {
 public:
  StripBuilder(std::vector<Triangle> triangles, std::size_t vertex_count)
      : triangles_(std::move(triangles)),
        across_(sides_across(triangles_, vertex_count)),
        is_done_(triangles_.size(), false),
        cache_(vertex_count) {}

  std::vector<Triangle> run() {
    ordered_.reserve(triangles_.size());
    std::size_t cursor = 0;
    while (ordered_.size() < triangles_.size()) {
      std::uint32_t start = next_candidate();
      if (start == kNone) {
        while (is_done_[cursor]) ++cursor;
        start = static_cast<std::uint32_t>(cursor);
      }
      grow_strip(start);
    }
    return std::move(ordered_);
  }

 private:
  static std::uint32_t corner_after(std::uint32_t corner) { return corner / 3 * 3 + (corner + 1) % 3; }
  std::uint32_t corner_vertex(std::uint32_t corner) const { return triangles_[corner / 3][corner % 3]; }

  // Of the neighbours found last, first those at the beginning of the last strip, the one with the most
  // corners in the cache, and of these the one with the fewest neighbours left, lest it stay alone.
  std::uint32_t next_candidate() {
    std::array<std::uint32_t, kMostCandidates> open{};
    std::size_t count = 0;
    std::uint32_t best = kNone;
    std::ptrdiff_t best_score = -1;
    for (; !candidates_.empty() && count < open.size(); candidates_.pop_back()) {
      const std::uint32_t triangle = candidates_.back();
      if (is_done_[triangle]) continue;
      open[count++] = triangle;
      const Triangle& t = triangles_[triangle];
      const auto hits = std::count_if(t.begin(), t.end(), [&](std::uint32_t v) { return cache_.holds(v); });
      const std::ptrdiff_t score = 4 * hits + 3 - open_neighbours(triangle);
      if (score <= best_score) continue;
      best = triangle;
      best_score = score;
    }
    candidates_.insert(candidates_.end(), open.rend() - static_cast<std::ptrdiff_t>(count), open.rend());
    return best;
  }

  // The corner at which the triangle across the side begins it, if it is still to be visited.
  std::uint32_t open_across(std::uint32_t side) const {
    const std::uint32_t other = across_[side];
    return other == kNone || is_done_[other / 3] ? kNone : other;
  }

  int open_neighbours(std::uint32_t triangle) const {
    int count = 0;
    for (std::uint32_t side = 3 * triangle; side < 3 * triangle + 3; ++side)
      count += open_across(side) == kNone ? 0 : 1;
    return count;
  }

  // The third corner of the triangle across is in the cache.
  bool leads_to_cached(std::uint32_t other) const {
    return cache_.holds(corner_vertex(corner_after(corner_after(other))));
  }

  // The side across which to leave a strip's first triangle: towards a triangle whose third corner is in the
  // cache, if there is one.
  std::uint32_t first_exit(std::uint32_t triangle) const {
    std::uint32_t best = 3 * triangle;
    int best_score = 0;
    for (std::uint32_t side = 3 * triangle; side < 3 * triangle + 3; ++side) {
      const std::uint32_t other = open_across(side);
      const int score = other == kNone ? 0 : leads_to_cached(other) ? 2 : 1;
      if (score > best_score) {
        best = side;
        best_score = score;
      }
    }
    return best;
  }

  void visit(std::uint32_t triangle, const Triangle& turned) {
    is_done_[triangle] = true;
    ordered_.push_back(turned);
    strip_.push_back(triangle);
    for (const std::uint32_t v : turned) cache_.use(v);
  }

  // Until nothing is left beside it, or until the cache would forget the vertices that the next strip, along
  // this one, is to find there.
  void grow_strip(std::uint32_t start) {
    strip_.clear();
    const std::uint32_t misses_before = cache_.misses();
    // The side by which a strip goes on as it comes, and the one for which it must turn.
    std::uint32_t natural = first_exit(start);
    std::uint32_t turn = kNone;
    {
      const std::uint32_t a = corner_vertex(natural);
      const std::uint32_t b = corner_vertex(corner_after(natural));
      const std::uint32_t opposite = corner_vertex(corner_after(corner_after(natural)));
      visit(start, is_odd_ ? Triangle{b, opposite, a} : Triangle{opposite, a, b});
    }
    while (cache_.misses() - misses_before < kMostMisses) {
      const std::uint32_t ahead = open_across(natural);
      const std::uint32_t aside = turn == kNone ? kNone : open_across(turn);
      // A turn takes one index more. It keeps to what was visited before, rather than leave gaps there.
      const bool turns =
          aside != kNone && (ahead == kNone || (leads_to_cached(aside) && !leads_to_cached(ahead)));
      const std::uint32_t entry = turns ? aside : ahead;
      if (entry == kNone) break;
      if (!turns) is_odd_ = !is_odd_;
      // An even window begins with the entry's first corner, an odd one with its second.
      const std::uint32_t next = corner_after(entry);
      const std::uint32_t third = corner_after(next);
      visit(entry / 3, {corner_vertex(entry), corner_vertex(next), corner_vertex(third)});
      natural = is_odd_ ? third : next;
      turn = is_odd_ ? next : third;
    }
    is_odd_ = !is_odd_;
    for (auto t = strip_.rbegin(); t != strip_.rend(); ++t)
      for (std::uint32_t side = 3 * *t; side < 3 * *t + 3; ++side)
        if (const std::uint32_t other = open_across(side); other != kNone) candidates_.push_back(other / 3);
  }

  static constexpr std::size_t kMostCandidates = 16;
  // A choice: with 4 there would be 0.77 misses per triangle instead of 0.80 and three more bits per vertex,
  // without a limit 0.93 and four less.
  static constexpr std::uint32_t kMostMisses = VertexCache::kSize - 3;

  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> across_;
  std::vector<bool> is_done_;
  VertexCache cache_;
  std::vector<Triangle> ordered_;
  std::vector<std::uint32_t> strip_;       // the triangles of this one
  std::vector<std::uint32_t> candidates_;  // a stack
  bool is_odd_ = false;                    // the window of the next triangle to come
};

}  // namespace

void order_in_strips(std::vector<Triangle>& triangles, std::size_t vertex_count) {
  const auto end = std::stable_partition(triangles.begin(), triangles.end(),
                                         [](const Triangle& t) { return !names_a_vertex_twice(t); });
  const std::vector<Triangle> ordered = StripBuilder({triangles.begin(), end}, vertex_count).run();
  std::copy(ordered.begin(), ordered.end(), triangles.begin());
}

Strip strip_of(std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> strip;
  strip.reserve(2 * triangles.size());
  const auto is_odd = [](std::size_t window) { return window % 2 == 1; };
  // Whether window `window`, which begins with a and b, can be that of the triangle.
  const auto fits = [&](const Triangle& t, std::size_t window, std::uint32_t a, std::uint32_t b) {
    const Triangle w = exchanged(t, is_odd(window));
    return w[0] == a && w[1] == b;
  };
  std::size_t i = 0;
  for (; i < triangles.size() && !names_a_vertex_twice(triangles[i]); ++i) {
    const Triangle& t = triangles[i];
    if (strip.empty() || !fits(t, strip.size() - 2, strip[strip.size() - 2], strip.back())) {
      const Triangle w = exchanged(t, is_odd(strip.size()));  // the joint does not change it
      if (!strip.empty()) strip.insert(strip.end(), {strip.back(), w[0]});
      strip.insert(strip.end(), {w[0], w[1]});
    }
    const std::size_t window = strip.size() - 2;
    const std::uint32_t a = strip[window];
    const std::uint32_t b = strip[window + 1];
    if (i + 1 < triangles.size() && !fits(triangles[i + 1], window + 1, b, t[2]) &&
        fits(triangles[i + 1], window + 2, a, t[2]))
      strip.push_back(a);
    strip.push_back(t[2]);
  }
  return {std::move(strip), i};
}

std::size_t triangles_of_strip(std::span<const std::uint32_t> strip, std::span<Triangle> triangles) {
  std::size_t count = 0;
  for (std::size_t k = 0; k + 2 < strip.size(); ++k) {
    const Triangle window{strip[k], strip[k + 1], strip[k + 2]};
    if (names_a_vertex_twice(window)) continue;
    if (count == triangles.size()) return count + 1;
    triangles[count++] = exchanged(window, k % 2 == 1);
  }
  return count;
}

}  // namespace colossus::codec::paper
