#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>

#include "apps/commands.h"
#include "core/temporary_files.h"
#include "render/output.h"

namespace glowworm {

namespace {

/// Opens what the caller closed of standard input, output and error (2>&-), so that no file that is opened later gets
/// their numbers and with them the messages.
void open_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = open("/dev/null", O_RDWR);
  if (descriptor > STDERR_FILENO) close(descriptor);
}

int run_program(int argc, char** argv) {
  CLI::App program("Glowworm: global illumination from photon maps, fast on one CPU, with nothing to tune.");
  program.set_version_flag("--version", std::string("glowworm ") + version());
  program.require_subcommand(1);
  program.footer(
      "\nExamples:\n  glowworm render builtin:cornell -o cornell.png\n  glowworm info builtin:atrium\n"
      "  glowworm compare cornell.exr reference.exr\n\n'glowworm COMMAND --help' lists the options of a command.");
  int exit_status = 0;
  add_render_command(program, exit_status);
  add_view_command(program, exit_status);
  add_info_command(program);
  add_compare_command(program, exit_status);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;
  }
  return exit_status;
}

/// Prints without allocating memory or throwing. Returns the status given.
int fail(const char* message, int status) noexcept {
  std::fprintf(stderr, "glowworm: error: %s\n", message);
  return status;
}

}  // namespace

}  // namespace glowworm

int main(int argc, char** argv) {
  glowworm::open_standard_streams();
  glowworm::remove_temporary_files_at_signals();
  int status = 1;
  try {
    status = glowworm::run_program(argc, argv);
  } catch (const glowworm::CommandLineError& error) {
    return glowworm::fail(error.what(), 2);
  } catch (const std::bad_alloc&) {
    return glowworm::fail("out of memory\n  Try a smaller --size, or a smaller --memory.", 1);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::broken_pipe) return 1;
    if (error.code() != std::errc::resource_unavailable_try_again) return glowworm::fail(error.what(), 1);
    return glowworm::fail(
        "no thread can be started\n  Leave the program more memory or threads (ulimit -v, ulimit -u).", 1);
  } catch (const std::exception& error) {
    return glowworm::fail(error.what(), 1);
  }
  std::cout.flush();
  errno = 0;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout) return status;
  // A reader that has seen enough (head) is no error to speak of.
  return errno == EPIPE ? 1 : glowworm::fail("standard output cannot be written", 1);
}
