// Private to this folder: messages of any size between ranks, sent and received without blocking.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "core/bytes.hpp"

namespace colossus::cluster {

struct Message {
  int peer = 0;            // the receiver of a message to send, the sender of a received one
  std::uint32_t kind = 0;  // the user's
  std::uint64_t task = 0;  // the user's
  core::Bytes payload;
};

// One rank's end of a conversation with some peers. A message is a small header, then its payload in pieces;
// MPI keeps the order of what one rank sends to another, which is how pieces find their header. Every peer
// must send one last message: the port knows by it that no receive may be left posted when the conversation
// is over. To be destroyed only after poll() returned nothing while is_finished().
class MessagePort {
 public:
  // `peer_count` peers will send messages to this port.
  MessagePort(MPI_Comm comm, int peer_count, std::size_t piece_bytes);

  // Starts to send; the port keeps the payload until it has left.
  void send(Message message, bool is_last = false);

  // Moves everything under way on, and returns one message that has arrived whole, if there is one. Messages
  // of one peer come in the order in which they were sent, unless their payloads are of several pieces or
  // large.
  std::optional<Message> poll();

  // All peers have sent their last message, all were returned by poll(), and all sends are complete.
  bool is_finished() const;

 private:
  struct Header {
    std::uint64_t task;
    std::uint64_t size;
    std::uint32_t kind;
    std::uint32_t is_last;
  };
  // On the heap each, since MPI holds their addresses.
  struct Transfer {
    Header header;
    Message message;
    std::vector<MPI_Request> requests;
  };

  void accept_headers();
  void complete_sends();

  MPI_Comm comm_;
  int open_peers_;  // peers whose last header has not arrived
  std::size_t piece_bytes_;
  Header header_{};
  MPI_Request header_request_ = MPI_REQUEST_NULL;
  std::deque<std::unique_ptr<Transfer>> outgoing_;
  std::deque<std::unique_ptr<Transfer>> incoming_;
};

}  // namespace colossus::cluster
