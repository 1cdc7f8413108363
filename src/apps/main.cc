#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "apps/commands.h"
#include "core/temporary_files.h"
#include "render/output.h"

int main(int argc, char** argv) {
  CLI::App program("Glowworm: global illumination from photon maps, fast on one CPU, with nothing to tune.");
  program.set_version_flag("--version", std::string("glowworm ") + glowworm::version());
  program.require_subcommand(1);
  program.footer(
      "\nExamples:\n  glowworm render builtin:cornell -o cornell.png\n  glowworm info builtin:atrium\n"
      "  glowworm compare cornell.exr reference.exr\n\n'glowworm COMMAND --help' lists the options of a command.");
  glowworm::remove_temporary_files_at_signals();
  int exit_status = 0;
  glowworm::add_render_command(program, exit_status);
  glowworm::add_view_command(program, exit_status);
  glowworm::add_info_command(program);
  glowworm::add_compare_command(program, exit_status);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "glowworm: error: out of memory\n  Try a smaller --size, or a smaller --memory.\n");
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "glowworm: error: {}\n", error.what());
    return 1;
  }
  return exit_status;
}
