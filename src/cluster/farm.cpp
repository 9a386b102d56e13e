// The conversation: rank 0 sends kTask messages and one kStop to each worker; a worker answers each task that
// it worked on with kResult or kFailure, and the kStop with kDone. kStop overtakes tasks that wait at the
// worker, which are then dropped: in order it is sent only when the worker has none, after a failure or a
// request to stop at once.
#include "cluster/farm.hpp"

#include <chrono>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "cluster/message_port.hpp"
#include "cluster/mpi_calls.hpp"
#include "cluster/stop.hpp"

namespace colossus::cluster {
namespace {

enum MessageKind : std::uint32_t { kTask, kStop, kResult, kFailure, kDone };

constexpr int kTasksPerWorker = 2;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

core::Error with_place(const core::Error& error, std::uint64_t task, int rank) {
  if (error.status() == core::Status::kStopped) return error;
  return {error.status(), fmt::format("{} (task {} on rank {})", error.what(), task, rank)};
}

class Master {
 public:
  Master(const Communicator& ranks, std::size_t task_count, const MakeTask& make_task,
         const TakeResult& on_result)
      : worker_count_(ranks.size() - 1),
        task_count_(task_count),
        make_task_(make_task),
        on_result_(on_result),
        port_(ranks.impl().farm, worker_count_, ranks.impl().piece_bytes),
        workers_(static_cast<std::size_t>(ranks.size())) {}

  // Returns the failure, if any.
  std::optional<core::Error> run() {
    stop_if_requested();
    for (int round = 0; round < kTasksPerWorker; ++round)
      for (int worker = 1; worker <= worker_count_; ++worker) hand_out(worker);
    for (int worker = 1; worker <= worker_count_; ++worker) stop_if_idle(worker);
    Backoff backoff;
    while (!port_.is_finished()) {
      stop_if_requested();
      if (std::optional<Message> message = port_.poll()) {
        take(std::move(*message));
        backoff.reset();
      } else {
        backoff.pause();
      }
    }
    return failure_;
  }

 private:
  struct Worker {
    int held_tasks = 0;
    bool is_stopped = false;
  };
  Worker& state(int worker) { return workers_[static_cast<std::size_t>(worker)]; }

  void hand_out(int worker) {
    if (failure_ || next_task_ == task_count_) return;
    const std::size_t task = next_task_++;
    try {
      port_.send({worker, kTask, task, make_task_(task)});
      ++state(worker).held_tasks;
    } catch (...) {
      fail_here(task);
    }
  }

  void take(Message message) {
    if (message.kind == kDone) return;
    const int worker = message.peer;
    --state(worker).held_tasks;
    if (message.kind == kFailure) {
      const core::Error error = decode_error(message.payload);
      fail(with_place(error, message.task, worker), message.task);
      return;
    }
    hand_out(worker);  // first, so that the worker does not wait for what is done with its result
    if (!failure_) {
      try {
        on_result_(message.task, std::move(message.payload));
      } catch (...) {
        fail_here(message.task);
      }
    }
    stop_if_idle(worker);
  }

  void stop_if_requested() {
    if (failure_ || !is_stop_requested()) return;
    failure_ = stop_error();
    stop_all();
  }

  void stop_if_idle(int worker) {
    if (state(worker).held_tasks == 0) stop(worker);
  }

  void stop(int worker) {
    if (std::exchange(state(worker).is_stopped, true)) return;
    port_.send({worker, kStop, 0, {}}, true);
  }

  // Of a callback of rank 0, which takes precedence over any worker's.
  void fail_here(std::size_t task) {
    const core::Error error = with_place(core::error_of_current_exception(), task, 0);
    if (failed_here_) return;
    failed_here_ = true;
    failure_.emplace(error);
    stop_all();
  }

  void fail(const core::Error& error, std::uint64_t task) {
    // That a stop was requested is what is told when nothing else has happened.
    const bool is_first = !failure_ || failure_->status() == core::Status::kStopped;
    const bool is_lower = error.status() != core::Status::kStopped && task < failed_task_;
    if (!failed_here_ && (is_first || is_lower)) {
      failure_.emplace(error);
      failed_task_ = task;
    }
    stop_all();
  }

  void stop_all() {
    for (int worker = 1; worker <= worker_count_; ++worker) stop(worker);
  }

  int worker_count_;
  std::size_t task_count_;
  const MakeTask& make_task_;
  const TakeResult& on_result_;
  MessagePort port_;
  std::vector<Worker> workers_;  // by rank; [0] is not used
  std::size_t next_task_ = 0;
  std::optional<core::Error> failure_;
  std::uint64_t failed_task_ = 0;
  bool failed_here_ = false;
};

class Worker {
 public:
  Worker(const Communicator& ranks, const Work& work)
      : work_(work), port_(ranks.impl().farm, 1, ranks.impl().piece_bytes) {}

  FarmShare run() {
    Backoff backoff;
    for (;;) {
      receive();
      if (is_stopped_) break;
      if (is_stop_requested()) tasks_.clear();  // kStop is on its way
      if (tasks_.empty()) {
        backoff.pause();
        continue;
      }
      const Message task = std::move(tasks_.front());
      tasks_.pop_front();
      do_task(task);
      backoff.reset();
    }
    port_.send({0, kDone, 0, {}}, true);
    backoff.reset();
    while (!port_.is_finished()) {
      receive();
      backoff.pause();
    }
    return share_;
  }

 private:
  void receive() {
    while (std::optional<Message> message = port_.poll()) {
      if (message->kind == kStop)
        is_stopped_ = true;
      else if (!has_failed_)
        tasks_.push_back(std::move(*message));
    }
  }

  void do_task(const Message& task) {
    const auto start = std::chrono::steady_clock::now();
    Message answer{0, kResult, task.task, {}};
    try {
      answer.payload = work_(task.payload);
    } catch (...) {
      answer.kind = kFailure;
      answer.payload = encode_error(core::error_of_current_exception());
      has_failed_ = true;  // kStop is on its way: nothing that waits here need be begun
      tasks_.clear();
    }
    share_.work_seconds += seconds_since(start);
    ++share_.task_count;
    port_.send(std::move(answer));
  }

  const Work& work_;
  MessagePort port_;
  std::deque<Message> tasks_;
  bool is_stopped_ = false;
  bool has_failed_ = false;
  FarmShare share_;
};

FarmShare run_alone(std::size_t task_count, const MakeTask& make_task, const Work& work,
                    const TakeResult& on_result) {
  FarmShare share;
  for (std::size_t task = 0; task < task_count; ++task) {
    try {
      throw_if_stop_requested();
      const core::Bytes bytes = make_task(task);
      const auto start = std::chrono::steady_clock::now();
      core::Bytes result = work(bytes);
      share.work_seconds += seconds_since(start);
      ++share.task_count;
      on_result(task, std::move(result));
    } catch (...) {
      const core::Error error = with_place(core::error_of_current_exception(), task, 0);
      throw AgreedError(error.status(), error.what());
    }
  }
  return share;
}

}  // namespace

FarmShare run_farm(const Communicator& ranks, std::size_t task_count, const MakeTask& make_task,
                   const Work& work, const TakeResult& on_result) {
  const auto start = std::chrono::steady_clock::now();
  FarmShare share;
  if (ranks.size() == 1) {
    share = run_alone(task_count, make_task, work, on_result);
  } else {
    core::Bytes verdict;  // empty: no failure
    if (ranks.is_root()) {
      if (const auto failure = Master(ranks, task_count, make_task, on_result).run())
        verdict = encode_error(*failure);
    } else {
      share = Worker(ranks, work).run();
    }
    ranks.broadcast(verdict);
    if (!verdict.empty()) {
      const core::Error error = decode_error(verdict);
      throw AgreedError(error.status(), error.what());
    }
  }
  share.total_seconds = seconds_since(start);
  return share;
}

}  // namespace colossus::cluster
