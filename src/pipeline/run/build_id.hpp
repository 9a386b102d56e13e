// Which sources this program was built from: finer than a release, since scratch of one development build is
// of no use to another.
#pragma once

namespace colossus::pipeline::run {

// 40 hexadecimal digits, or "none" where the sources were no repository.
const char* build_commit();

// The commit, and a hash over all sources, which changes that nobody has committed change too.
const char* build_id();

}  // namespace colossus::pipeline::run
