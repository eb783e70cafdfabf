// Runs another program by argument list (never through a shell).
#include "core/child_process.h"

#include "core/error.h"
#include "core/stop_request.h"
#include "core/timer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/personality.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr int kPoll_ms = 100;
constexpr double kGrace_s = 5.0;  // from SIGTERM to SIGKILL
constexpr size_t kLastLines = 20;
constexpr size_t kMaxLineBytes = 65536;  // longer lines are cut into several

struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) {
      throw EnvironmentError(fmt::format("cannot open a pipe ({})", std::strerror(errno)));
    }
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    CloseRead();
    CloseWrite();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void CloseRead() { Close(read_end); }
  void CloseWrite() { Close(write_end); }
  static void Close(int& fd) {
    if (fd >= 0) close(fd);
    fd = -1;
  }
};

// Everything that exec needs, prepared before the fork: after it only async-signal-safe calls are
// allowed.
struct Command {
  std::vector<std::string> arguments, environment;
  std::vector<char*> argv, envp;

  Command(const fs::path& program, const std::vector<std::string>& given,
          const ChildOptions& options) {
    arguments.push_back(program.string());
    arguments.insert(arguments.end(), given.begin(), given.end());
    for (char** entry = environ; *entry != nullptr; ++entry) {
      const std::string text = *entry;
      const std::string name = text.substr(0, text.find('='));
      bool replaced = false;
      for (const auto& [key, value] : options.environment) replaced |= key == name;
      if (!replaced) environment.push_back(text);
    }
    for (const auto& [key, value] : options.environment) environment.push_back(key + "=" + value);
    for (std::string& text : arguments) argv.push_back(text.data());
    for (std::string& text : environment) envp.push_back(text.data());
    argv.push_back(nullptr);
    envp.push_back(nullptr);
  }
};

[[noreturn]] void BecomeChild(const Command& command, const char* folder, int output, int report,
                              const ChildOptions& options, pid_t parent) {
  const auto fail = [report] {
    const int error = errno;
    [[maybe_unused]] const ssize_t n = write(report, &error, sizeof(error));
    _exit(127);
  };
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);  // the parent died before prctl
  // A terminal's Ctrl-C reaches the parent alone, which asks the child to stop: of two requests,
  // the second would end a stage at once.
  setpgid(0, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE}) std::signal(number, SIG_DFL);
  const int null = open("/dev/null", O_RDONLY);
  if (null < 0 || dup2(null, STDIN_FILENO) < 0 || dup2(output, STDOUT_FILENO) < 0 ||
      dup2(output, STDERR_FILENO) < 0) {
    fail();
  }
  if (folder != nullptr && chdir(folder) != 0) fail();
  if (options.max_memory_bytes > 0) {
    const rlimit limit{options.max_memory_bytes, options.max_memory_bytes};
    if (setrlimit(RLIMIT_AS, &limit) != 0) fail();
  }
  if (options.fixed_addresses) {
    const int now = personality(0xffffffff);  // only queries
    if (now >= 0) personality(static_cast<unsigned long>(now) | ADDR_NO_RANDOMIZE);
  }
  execve(command.argv[0], command.argv.data(), command.envp.data());
  fail();
  _exit(127);
}

// Cuts a byte stream into lines; a carriage return ends a line too, as progress meters print it.
class LineCutter {
 public:
  explicit LineCutter(std::function<void(const std::string&)> on_line)
      : on_line_(std::move(on_line)) {}
  void Add(const char* bytes, size_t size) {
    for (size_t i = 0; i < size; ++i) {
      const bool end = bytes[i] == '\n' || bytes[i] == '\r';
      if (!end) line_ += bytes[i];
      if (end || line_.size() >= kMaxLineBytes) Finish();
    }
  }
  void Finish() {
    if (!line_.empty()) on_line_(line_);
    line_.clear();
  }

 private:
  std::function<void(const std::string&)> on_line_;
  std::string line_;
};

// Kills and reaps the child if it still exists when an exception leaves the scope.
struct ChildGuard {
  pid_t pid;
  bool reaped = false;
  ~ChildGuard() {
    if (reaped) return;
    kill(pid, SIGKILL);
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  // True if the child has ended.
  bool Poll(int* status) {
    if (!reaped && waitpid(pid, status, WNOHANG) == pid) reaped = true;
    return reaped;
  }
};

std::FILE* OpenLog(const fs::path& path) {
  if (path.empty()) return nullptr;
  std::FILE* file = std::fopen(path.c_str(), "ae");
  if (file == nullptr) {
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({})", path.string(), std::strerror(errno)));
  }
  return file;
}

}  // namespace

fs::path FindProgram(const std::string& name) {
  const auto runnable = [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) return runnable(name) ? fs::absolute(name) : fs::path();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path candidate = fs::path(folder.empty() ? "." : folder) / name;
    if (runnable(candidate)) return fs::absolute(candidate);
  }
  return {};
}

ChildResult RunChild(const fs::path& program, const std::vector<std::string>& arguments,
                     const ChildOptions& options) {
  const std::string name = program.filename().string();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> log(
      OpenLog(options.log),
      [](std::FILE* file) { return file != nullptr ? std::fclose(file) : 0; });
  const Command command(fs::absolute(program), arguments, options);
  const std::string folder = options.working_folder.string();
  Pipe output, report;
  const Timer timer;
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0)
    throw EnvironmentError(fmt::format("cannot start {} ({})", name, std::strerror(errno)));
  if (pid == 0) {
    BecomeChild(command, folder.empty() ? nullptr : folder.c_str(), output.write_end,
                report.write_end, options, parent);
  }
  ChildGuard child{pid};
  output.CloseWrite();
  report.CloseWrite();
  int exec_error = 0;
  ssize_t reported = 0;
  while ((reported = read(report.read_end, &exec_error, sizeof(exec_error))) < 0 &&
         errno == EINTR) {
  }
  if (reported > 0) {
    throw EnvironmentError(
        fmt::format("cannot start {} ({})", program.string(), std::strerror(exec_error)));
  }

  ChildResult result;
  LineCutter lines([&](const std::string& line) {
    if (result.last_lines.size() == kLastLines) result.last_lines.erase(result.last_lines.begin());
    result.last_lines.push_back(line);
    if (log) {
      std::fputs((line + "\n").c_str(), log.get());
      std::fflush(log.get());
    }
    if (options.on_line) options.on_line(line);
  });

  int status = 0;
  bool timed_out = false, ended = false;
  double stop_asked_s = -1;
  // A grandchild may keep the pipe open after the child has ended; only the child counts.
  while (!ended) {
    pollfd waiting{output.read_end, POLLIN, 0};
    const int ready = poll(&waiting, 1, kPoll_ms);
    ended = ready <= 0 && child.Poll(&status);
    if (ready > 0) {
      char block[4096];
      const ssize_t n = read(output.read_end, block, sizeof(block));
      if (n > 0) lines.Add(block, size_t(n));
      if (n == 0) {
        ended = child.Poll(&status);
        if (!ended) usleep(1000);  // output closed, process not yet ended
      }
    }
    timed_out = timed_out || (options.time_limit_s > 0 && timer.seconds() > options.time_limit_s);
    if (!ended && (timed_out || StopRequested())) {
      if (stop_asked_s < 0) {
        stop_asked_s = timer.seconds();
        kill(pid, SIGTERM);
      } else if (timer.seconds() - stop_asked_s > kGrace_s) {
        kill(pid, SIGKILL);
      }
    }
  }
  lines.Finish();
  result.seconds = timer.seconds();
  result.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  ThrowIfStopRequested(name + " was stopped");
  if (timed_out) {
    throw ChildTimedOut(
        fmt::format("{} did not end within {:g} s and was stopped", name, options.time_limit_s));
  }
  return result;
}

}  // namespace tetrec
