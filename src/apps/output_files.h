// The files that a command writes.
#pragma once
#include <functional>
#include <map>
#include <set>
#include <string>

namespace glowworm {

/// All files that a command writes, and those that it must not write over. A command adds every file before it begins
/// its work. A file that cannot be written keeps none of the others from it: you get a warning at once, and an error at
/// the end.
class OutputFiles {
 public:
  /// Adds a file that is read. Throws CommandLineError where it is one that is written.
  /// @param what the place on the command line that names it, for messages
  void add_input(const std::string& what, const std::string& path);
  /// Adds a file that is written. Throws CommandLineError where it is one that was added already.
  void add(const std::string& what, const std::string& path);
  /// Throws CommandLineError where `path` is one of the files that were added.
  void check(const std::string& what, const std::string& path) const;

  /// Finds out whether a file can be written, without leaving anything behind. Pipes and devices are not touched.
  /// Throws Error where the name or the rights are wrong; where the disk is full or fails, warns and returns false.
  bool probe(const std::string& path);

  /// Runs `work`, which writes the file. Where it throws, warns unless it has done so for this file, and returns false.
  bool write(const std::string& path, const std::function<void()>& work);

  /// Throws Error that names every file whose last write failed, if there is one.
  void throw_if_any_failed() const;

 private:
  bool note_failure(const std::string& path, const std::string& message);

  struct Named {
    std::string what;  // names the file
    bool written;
  };
  std::map<std::string, Named> named_;     // by output_identity()
  std::set<std::string> warned_, failed_;  // paths
};

}  // namespace glowworm
