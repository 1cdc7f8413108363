// What programs that read files of strangers do to themselves (core/child_process.h starts them).
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>

namespace glowworm {

/// The descriptor through which a child process talks to its parent.
inline constexpr int kChildDescriptor = 3;

/// Exit statuses of child processes other than 0.
enum class ChildExit : int {
  refused = 1,        ///< the file cannot be read; a message replaces the answer
  out_of_memory = 2,  ///< the memory limit was reached
  misused = 3         ///< wrong arguments or requests
};

/// Ends this process at once. No destructors run: after a damaged file, a library's destructors may crash.
[[noreturn]] void end_child(ChildExit status);

/// Ignores Ctrl-C, which the parent handles; closes all descriptors but kChildDescriptor and standard streams; and
/// forbids to write files. Memory that is refused ends the process from here on.
void confine();

/// Limits the address space of this process, and the processor time that it may take from now on.
void limit_child(std::uint64_t memory_bytes, unsigned cpu_seconds);

/// Writes bytes to the parent; ends the process if it does not take them.
void send_to_parent(const void* data, std::size_t size);

/// Reads one file in this process, confined, and ends it. If `read` throws, its message replaces the answer; without
/// enough memory, there is none.
/// @param argv the program, the file, limits of memory (bytes) and processor time (s), and others
/// @param count of argv that the program takes @param read writes the answer by send_to_parent()
[[noreturn]] void read_for_parent(int argc, char** argv, int count, const std::function<void()>& read);

}  // namespace glowworm
