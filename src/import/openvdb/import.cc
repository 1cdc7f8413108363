#include "import/openvdb/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "import/openvdb/hand_over.h"
#include "import/reader_process.h"

namespace glowworm {

namespace {

/// @param grid empty: only names
OpenVdbAnswer ask_openvdb(const std::string& path, const std::string& grid, MemoryBudget& budget,
                          const ChildLimits& limits, const std::string& program) {
  const ReaderProgram reader{"glowworm-openvdb", "OpenVDB", "Write the file again.", program};
  Reservation held(budget, "grids", 0);
  const std::string bytes = run_reader(reader, path, {grid}, limits_for(path, budget, limits), held);
  held.grow(bytes.size());  // values take the same in both forms
  OpenVdbAnswer answer = read_openvdb_answer(bytes, path);
  record_input_file(path);
  return answer;
}

}  // namespace

VoxelGrid read_openvdb(const std::string& path, const std::string& grid, MemoryBudget& budget,
                       const ChildLimits& limits, const std::string& program) {
  OpenVdbAnswer answer = ask_openvdb(path, grid, budget, limits, program);
  if (!answer.found)
    throw Error({path}, fmt::format("has no grid '{}'", grid),
                fmt::format("It has: {}.", fmt::join(answer.names, ", ")));
  return std::move(answer.grid);
}

bool has_openvdb_grid(const std::string& path, const std::string& grid, MemoryBudget& budget) {
  const OpenVdbAnswer answer = ask_openvdb(path, "", budget, {}, {});
  return std::find(answer.names.begin(), answer.names.end(), grid) != answer.names.end();
}

}  // namespace glowworm
