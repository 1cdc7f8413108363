// The files that a command writes.
#pragma once
#include <functional>
#include <map>
#include <set>
#include <string>

namespace glowworm {

/// All files that a command writes, and the files that it must not overwrite. A command adds every file before it
/// starts work. If a file cannot be written, the others are still written: you get a warning at once, and an error at
/// the end.
class OutputFiles {
 public:
  /// Adds an input file, unless `path` is empty. Throws CommandLineError if it is also an output.
  /// @param what the argument that names the file, for messages
  void add_input(const std::string& what, const std::string& path);
  /// Adds an output file, unless `path` is empty. Throws CommandLineError if it was already added.
  void add(const std::string& what, const std::string& path);
  /// Throws CommandLineError if `path` is one of the added files.
  void check(const std::string& what, const std::string& path) const;

  /// Tests whether a file can be written, without leaving anything behind. Pipes and devices are not opened. Throws
  /// Error if the name or the permissions are wrong. Warns and returns false if the disk is full or broken.
  bool probe(const std::string& path);
  /// Probes all output files. Throws Error that names those that cannot be written, if there are any.
  void probe_all();

  /// Runs `work`, which writes the file. If it throws, returns false, and warns unless there was a warning for this
  /// file before.
  bool write(const std::string& path, const std::function<void()>& work);
  /// The same, unless `path` is empty, and prints that the file is written, unless it is standard output.
  /// @param how to add to the message; `work` may set it
  void write_and_report(const std::string& path, const std::function<void()>& work, const std::string& how = {});
  /// The same for a file that holds a text.
  void write_text(const std::string& path, const std::function<std::string()>& text);

  /// Throws Error that names every file whose last write failed, if there is any.
  void throw_if_any_failed() const;

 private:
  bool note_failure(const std::string& path, const std::string& message);

  struct Named {
    std::string what;  // the argument that names the file
    std::string path;  // of an output; empty: an input
  };
  std::map<std::string, Named> named_;     // by output_identity()
  std::set<std::string> warned_, failed_;  // paths
};

}  // namespace glowworm
