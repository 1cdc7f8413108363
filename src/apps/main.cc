#include <execinfo.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "apps/commands.h"
#include "core/names.h"
#include "core/option_names.h"
#include "core/parallel.h"
#include "core/temporary_files.h"
#include "core/text.h"
#include "core/version.h"
#include "settings/options.h"

namespace glowworm {

namespace {

/// Opens standard input, output and error if the caller closed them (2>&-). Otherwise files opened later would get
/// their numbers, and messages would go into these files.
void open_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = open("/dev/null", O_RDWR);
  if (descriptor > STDERR_FILENO) close(descriptor);
}

/// The command line, with quotes around words that a shell would split or expand.
std::string command_line(int argc, char** argv) {
  std::string text = "glowworm";
  for (int i = 1; i < argc; ++i) text += " " + shell_word(argv[i]);
  return text;
}

/// Throws a CommandLineError in the program's own words. @param error what CLI11 says @param first first argument
[[noreturn]] void refuse(const CLI::App& program, const CLI::ParseError& error, const std::string& first) {
  std::vector<std::string> names;
  if (program.get_subcommands().empty()) {
    for (const CLI::App* command : program.get_subcommands({})) names.push_back(command->get_name());
    throw CommandLineError(fmt::format("'{}' is not a command", first),
                           fmt::format("{}Choose from: {}.", did_you_mean(first, names), fmt::join(names, ", ")));
  }
  const CLI::App& command = *program.get_subcommands().front();
  const std::string help = fmt::format("'glowworm {} --help' lists its arguments and options.", command.get_name());
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& word : command.remaining())
    if (word.starts_with("-"))
      throw CommandLineError(fmt::format("'{}' is not an option of 'glowworm {}'", word, command.get_name()),
                             did_you_mean(word.substr(0, word.find('=')), names) + help);
  if (!command.remaining().empty())
    throw CommandLineError(fmt::format("'{}' is one argument too many", command.remaining().front()), help);
  const std::string text = error.what();
  const std::size_t missing = text.find(": 1 required");
  throw CommandLineError(missing == std::string::npos ? text : text.substr(0, missing) + " needs a value", help);
}

/// Refuses empty words, which are variables that a script did not set.
void refuse_empty_values(const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const bool is_cut = word.starts_with("--") && word.ends_with('=');
    if (is_cut || (word.empty() && i > 0 && words[i - 1].starts_with('-')))
      throw CommandLineError(fmt::format("{} has an empty value", is_cut ? word : words[i - 1]));
  }
}

int run_program(int argc, char** argv) {
  CLI::App program("Glowworm: global illumination from photon maps, fast on one CPU, with nothing to tune.",
                   "glowworm");
  program.set_version_flag("--version", std::string("glowworm ") + version());
  program.require_subcommand(1);
  program.footer(
      "\nExamples:\n  glowworm render builtin:cornell -o cornell.png\n  glowworm info builtin:atrium\n"
      "  glowworm measure builtin:ajar --grid y=0.8,0.5 -o lux.csv\n"
      "  glowworm compare cornell.exr reference.exr\n\n'glowworm COMMAND --help' lists the options of a command.");
  int exit_status = 0;
  add_render_command(program, command_line(argc, argv), exit_status);
  add_merge_command(program, command_line(argc, argv), exit_status);
  add_bake_command(program, command_line(argc, argv), exit_status);
  add_view_command(program, exit_status);
  add_measure_command(program, command_line(argc, argv), exit_status);
  add_glare_command(program, command_line(argc, argv), exit_status);
  add_daylight_command(program, command_line(argc, argv), exit_status);
  add_info_command(program, command_line(argc, argv));
  add_compare_command(program, command_line(argc, argv), exit_status);
  if (argc < 2) {
    std::fputs(program.help().c_str(), stderr);
    return 2;
  }
  refuse_empty_values({argv + 1, argv + argc});
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::ParseError& error) {
    refuse(program, error, argv[1]);
  }
  return exit_status;
}

/// Prints without allocating memory, and ends the program. Destructors of libraries do not run: some abort after memory
/// was refused.
[[noreturn]] void fail(const char* message, int status) noexcept {
  std::fflush(stdout);
  std::fprintf(stderr, "glowworm: error: %s\n", message);
  remove_temporary_files();
  _exit(status);
}

/// The same for messages that may hold names from files.
[[noreturn]] void fail(const std::exception& error, int status) { fail(printable(error.what()).c_str(), status); }

/// Whether standard output is a pipe whose reader has closed it, as head does.
bool reader_is_gone() {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  return poll(&out, 1, 0) > 0 && (out.revents & (POLLERR | POLLHUP)) != 0;
}

constexpr const char* kOutOfMemory =
    "out of memory\n  Close other programs, give a smaller --memory, or reduce the scene or the picture.";

/// For libraries that let std::bad_alloc leave a thread or a function that may not throw.
[[noreturn]] void terminated() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    fail(kOutOfMemory, 1);
  } catch (...) {
  }
  std::abort();
}

}  // namespace

}  // namespace glowworm

int main(int argc, char** argv) {
  // Loads what the C library needs to end threads; without memory left it would abort over that later.
  void* frame = nullptr;
  backtrace(&frame, 1);
  std::set_terminate(glowworm::terminated);
  glowworm::name_options_with_dashes(true);
  glowworm::open_standard_streams();
  glowworm::remove_temporary_files_at_signals();
  int status = 1;
  try {
    status = glowworm::run_program(argc, argv);
    glowworm::end_threads();
  } catch (const glowworm::CommandLineError& error) {
    glowworm::fail(error, 2);
  } catch (const std::bad_alloc&) {
    glowworm::fail(glowworm::kOutOfMemory, 1);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::broken_pipe) return 1;
    if (error.code() != std::errc::resource_unavailable_try_again) glowworm::fail(error, 1);
    glowworm::fail("no thread can be started\n  Raise the limits of memory or threads (ulimit -v, ulimit -u).", 1);
  } catch (const std::exception& error) {
    glowworm::fail(error, 1);
  }
  std::cout.flush();
  if (std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout) return status;
  // A reader that closes early causes no message. The failed write may be long ago, so its errno tells nothing.
  if (!glowworm::reader_is_gone()) glowworm::fail("standard output cannot be written", 1);
  return 1;
}
