#include "verify/verify.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace colossus::verify {

measure::VerifyReport verify(const reader::access::Statue& statue, const measure::VerifyOptions& options) {
  const auto all = schemes();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Scheme& s) { return s.name == statue.metadata().scheme; });
  COLOSSUS_CHECK(found != all.end(), "a scheme that can be opened cannot be verified");
  return found->verify(statue, options);
}

}  // namespace colossus::verify
