// rank_memory FOLDER COMMAND...: runs COMMAND and writes its largest resident set, in bytes, to
// FOLDER/rank_<rank>. Between mpirun and a program it measures each rank from outside, which neither mpirun
// nor time(1) does.
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: rank_memory FOLDER COMMAND...\n");
    return 2;
  }
  const pid_t child = fork();
  if (child == 0) {
    execvp(argv[2], argv + 2);
    std::perror(argv[2]);
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) {
    std::perror("rank_memory");
    return 1;
  }
  const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
  const std::string path = fmt::format("{}/rank_{}", argv[1], rank ? rank : "0");
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (!file) {
    std::perror(path.c_str());
    return 1;
  }
  fmt::print(file, "{}\n", static_cast<unsigned long long>(usage.ru_maxrss) * 1024ULL);
  std::fclose(file);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
