#include "apps/output_files.h"

#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <new>

#include "apps/commands.h"
#include "core/atomic_file.h"
#include "core/log.h"

namespace glowworm {

namespace {

/// Maximum number of files named in the error at the end: a full disk fails every frame of a session.
constexpr std::size_t kMaxNames = 8;

[[noreturn]] void refuse(const std::string& what, const std::string& path, const std::string& other) {
  throw CommandLineError(fmt::format("{} '{}' and {} are the same file", what, path, other), "Give each its own name.");
}

}  // namespace

void OutputFiles::add_input(const std::string& what, const std::string& path) {
  if (path.empty()) return;
  const auto [other, added] = named_.emplace(output_identity(path), Named{what, ""});
  if (!added && !other->second.path.empty()) refuse(what, path, other->second.what);
}

void OutputFiles::add(const std::string& what, const std::string& path) {
  if (path.empty()) return;
  check(what, path);
  if (const std::string identity = output_identity(path); !identity.empty())
    named_.emplace(identity, Named{what, path});
}

void OutputFiles::check(const std::string& what, const std::string& path) const {
  const auto other = named_.find(output_identity(path));
  if (other != named_.end() && !other->first.empty()) refuse(what, path, other->second.what);
}

bool OutputFiles::probe(const std::string& path) {
  std::error_code error;
  const auto type = std::filesystem::status(path, error).type();
  // Probing a pipe or a device would be visible to the reader at its other end.
  if (type == std::filesystem::file_type::fifo || type == std::filesystem::file_type::character) return true;
  try {
    const AtomicFile probe(path);
  } catch (const DiskError& failure) {
    return note_failure(path, failure.what());
  }
  return true;
}

void OutputFiles::probe_all() {
  for (const auto& [identity, named] : named_)
    if (!named.path.empty()) probe(named.path);
  throw_if_any_failed();
}

bool OutputFiles::write(const std::string& path, const std::function<void()>& work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
    return note_failure(path, path + ": out of memory");
  } catch (const std::exception& failure) {
    return note_failure(path, failure.what());
  }
  failed_.erase(path);
  return true;
}

void OutputFiles::write_and_report(const std::string& path, const std::function<void()>& work, const std::string& how) {
  if (!path.empty() && write(path, work) && path != kStandardOutput) inform(fmt::format("wrote {}{}", path, how));
}

void OutputFiles::write_text(const std::string& path, const std::function<std::string()>& text) {
  write_and_report(path, [&] { write_file(path, text()); });
}

bool OutputFiles::note_failure(const std::string& path, const std::string& message) {
  failed_.insert(path);
  if (warned_.size() < kMaxNames && warned_.insert(path).second) warn(message);
  return false;
}

void OutputFiles::throw_if_any_failed() const {
  if (failed_.empty()) return;
  std::string names;
  std::size_t named = 0;
  for (const std::string& path : failed_) {
    if (named++ == kMaxNames) {
      names += fmt::format(" and {} more", failed_.size() - kMaxNames);
      break;
    }
    names += (named > 1 ? ", " : "") + path;
  }
  throw Error("not written: " + names, "The warnings above say why.");
}

}  // namespace glowworm
