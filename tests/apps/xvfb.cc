#include "apps/xvfb.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>

namespace glowworm {

namespace {
constexpr int kStartMilliseconds = 20'000;
}

Xvfb::Xvfb() {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe for Xvfb");
  process_ = fork();
  if (process_ == 0) {
    close(ends[0]);
    const int nowhere = open("/dev/null", O_RDWR);
    dup2(nowhere, 0);
    dup2(nowhere, 1);
    dup2(nowhere, 2);
    const std::string descriptor = std::to_string(ends[1]);
    execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "1280x1024x24", "-nolisten", "tcp",
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(ends[1]);
  // It writes the number of its display when it is ready.
  std::string number;
  char c = 0;
  pollfd wait{ends[0], POLLIN, 0};
  while (c != '\n' && poll(&wait, 1, kStartMilliseconds) == 1 && read(ends[0], &c, 1) == 1)
    if (c != '\n') number += c;
  close(ends[0]);
  if (number.empty()) {
    kill();
    throw std::runtime_error("Xvfb did not start: install the package xvfb (scripts/install-packages)");
  }
  display_ = ":" + number;
}

Xvfb::~Xvfb() { kill(); }

void Xvfb::kill() {
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

}  // namespace glowworm
