#include "cluster/message_port.hpp"

#include <utility>

#include "cluster/mpi_calls.hpp"

namespace colossus::cluster {
namespace {

constexpr int kHeaderTag = 1;
constexpr int kPayloadTag = 2;

bool is_complete(std::vector<MPI_Request>& requests) {
  if (requests.empty()) return true;
  int done = 0;
  check_mpi(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE),
            "MPI_Testall");
  return done != 0;
}

}  // namespace

MessagePort::MessagePort(MPI_Comm comm, int peer_count, std::size_t piece_bytes)
    : comm_(comm), open_peers_(peer_count), piece_bytes_(piece_bytes) {}

void MessagePort::send(Message message, bool is_last) {
  outgoing_.push_back(std::make_unique<Transfer>());
  Transfer& transfer = *outgoing_.back();
  transfer.message = std::move(message);
  const Message& sent = transfer.message;
  transfer.header = {sent.task, sent.payload.size(), sent.kind, is_last ? 1U : 0U};
  check_mpi(MPI_Isend(&transfer.header, sizeof transfer.header, MPI_BYTE, sent.peer, kHeaderTag, comm_,
                      &transfer.requests.emplace_back(MPI_REQUEST_NULL)),
            "MPI_Isend");
  start_sends(sent.payload, sent.peer, kPayloadTag, comm_, piece_bytes_, transfer.requests);
}

std::optional<Message> MessagePort::poll() {
  accept_headers();
  complete_sends();
  for (auto it = incoming_.begin(); it != incoming_.end(); ++it) {
    if (!is_complete((*it)->requests)) continue;
    Message message = std::move((*it)->message);
    incoming_.erase(it);
    return message;
  }
  return std::nullopt;
}

bool MessagePort::is_finished() const { return open_peers_ == 0 && incoming_.empty() && outgoing_.empty(); }

void MessagePort::accept_headers() {
  while (open_peers_ > 0) {
    if (header_request_ == MPI_REQUEST_NULL)
      check_mpi(
          MPI_Irecv(&header_, sizeof header_, MPI_BYTE, MPI_ANY_SOURCE, kHeaderTag, comm_, &header_request_),
          "MPI_Irecv");
    int arrived = 0;
    MPI_Status status;
    check_mpi(MPI_Test(&header_request_, &arrived, &status), "MPI_Test");
    if (arrived == 0) return;
    if (header_.is_last != 0) --open_peers_;
    incoming_.push_back(std::make_unique<Transfer>());
    Transfer& transfer = *incoming_.back();
    transfer.message = {status.MPI_SOURCE, header_.kind, header_.task, core::Bytes(header_.size)};
    start_receives(transfer.message.payload, status.MPI_SOURCE, kPayloadTag, comm_, piece_bytes_,
                   transfer.requests);
  }
}

void MessagePort::complete_sends() {
  std::erase_if(outgoing_,
                [](const std::unique_ptr<Transfer>& transfer) { return is_complete(transfer->requests); });
}

}  // namespace colossus::cluster
