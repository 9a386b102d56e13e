#include "build/phase.hpp"

namespace colossus::build {

void run_phase(const Workspace& workspace, const std::string& name, std::size_t task_count,
               const cluster::MakeTask& make_task, const cluster::Work& work,
               const cluster::TakeResult& on_result) {
  (void)name;
  cluster::run_farm(workspace.ranks, task_count, make_task, work, on_result);
}

}  // namespace colossus::build
