// Requests to stop in order: by a signal to any rank, or by a time limit.
//
// A rank that receives one tells rank 0, which tells all others. Ranks look for such notices while they wait
// for each other, and whenever they ask is_stop_requested(); so a rank at work learns of it when it asks.
#pragma once

#include <optional>

#include "cluster/communicator.hpp"

namespace colossus::cluster {

// Collective, once. From now on SIGUSR1, SIGUSR2 and SIGTERM are requests to stop and do not end the program.
// `limit_seconds`: after so many seconds since the program started rank 0 makes such a request itself.
void watch_for_stop(const Communicator& ranks, std::optional<double> limit_seconds);

// Not collective. Whether this rank has heard of a request; it stays true. Some hundred nanoseconds. False
// before watch_for_stop().
bool is_stop_requested();

// Not collective. Throws stop_error().
void throw_if_stop_requested();

// Of status kStopped, says what the request was. Only after one.
core::Error stop_error();

}  // namespace colossus::cluster
