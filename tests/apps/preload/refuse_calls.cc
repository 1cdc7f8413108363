// Preloaded into the program by a test (LD_PRELOAD): refuses writes or memory from the start of main() to its end.
// Before main() and inside dlopen(), nothing is refused or counted: the program cannot catch errors there, and some
// libraries abort. Environment variables control it:
//   REFUSE_CALL=N        the N-th call that writes (1 is the first) fails with the number in REFUSE_ERRNO
//   REFUSE_MEMORY=N      the N-th allocation fails
//   REFUSE_MEMORY_TO=M   and all after it up to the M-th
//   REFUSE_EMBREE=N      the N-th allocation fails of those that Embree makes while it makes a device
//   REFUSE_NAMES=1       the names of machines are looked up for ever, as where no server answers
//   REFUSE_REPORT=FILE   at the end FILE holds how many calls and allocations there were
// Calls that the C library makes inside itself (stdio) are not seen.
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

std::atomic<bool> armed{false};
std::atomic<unsigned long> calls{0}, allocations{0};
unsigned long refused_call = 0, refused_from = 0, refused_to = 0;
int error_number = EIO;

unsigned long number_of(const char* name) {
  const char* text = getenv(name);
  return text ? strtoul(text, nullptr, 10) : 0;
}

/// Counts a call; true, with errno set, where it is to fail.
bool refuse_call() {
  if (!armed || ++calls != refused_call) return false;
  errno = error_number;
  return true;
}

thread_local unsigned long before_refusal = 0;  // allocations of this thread up to the one that fails; 0: none fails

thread_local int loading = 0;  // calls of dlopen() under way

bool refuse_memory() {
  if (!armed || loading > 0) return false;
  if (before_refusal > 0 && --before_refusal == 0) {
    errno = ENOMEM;
    return true;
  }
  const unsigned long number = ++allocations;
  if (number < refused_from || number > refused_to) return false;
  errno = ENOMEM;
  return true;
}

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }

// Files open for writing, whose close() may fail.
std::atomic<bool> written[1024];

int opened(int descriptor, int flags) {
  if (descriptor >= 0 && descriptor < 1024) written[descriptor] = writes(flags);
  return descriptor;
}

int (*program_main)(int, char**, char**) = nullptr;

int armed_main(int count, char** arguments, char** environment) {
  refused_call = number_of("REFUSE_CALL");
  refused_from = number_of("REFUSE_MEMORY");
  refused_to = number_of("REFUSE_MEMORY_TO");
  if (refused_from == 0) refused_from = ~0ul;
  if (refused_to < refused_from) refused_to = refused_from;
  if (const unsigned long number = number_of("REFUSE_ERRNO")) error_number = static_cast<int>(number);
  armed = true;
  const int status = program_main(count, arguments, environment);
  armed = false;
  if (const char* path = getenv("REFUSE_REPORT")) {
    if (FILE* report = fopen(path, "w")) {
      fprintf(report, "%lu %lu\n", calls.load(), allocations.load());
      fclose(report);
    }
  }
  return status;
}

mode_t mode_of(int flags, va_list list) { return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0; }

}  // namespace

extern "C" {

int __libc_start_main(int (*main_function)(int, char**, char**), int count, char** arguments, void (*start)(),
                      void (*end)(), void (*loader_end)(), void* stack_end) {
  program_main = main_function;
  return next<int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*)>(
      "__libc_start_main")(armed_main, count, arguments, start, end, loader_end, stack_end);
}

// Looks for the program's own libraries by the run path of this one, which the build sets.
void* dlopen(const char* name, int flags) {
  ++loading;
  void* library = next<void*(const char*, int)>("dlopen")(name, flags);
  --loading;
  return library;
}

void* rtcNewDevice(const char* settings) {
  auto* make = next<void*(const char*)>("rtcNewDevice");
  before_refusal = number_of("REFUSE_EMBREE");
  void* device = make(settings);
  before_refusal = 0;
  return device;
}

int getaddrinfo(const char* host, const char* port, const addrinfo* wanted, addrinfo** found) {
  while (armed && number_of("REFUSE_NAMES") > 0 && (wanted->ai_flags & AI_NUMERICHOST) == 0) pause();
  return next<int(const char*, const char*, const addrinfo*, addrinfo**)>("getaddrinfo")(host, port, wanted, found);
}

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  if (writes(flags) && refuse_call()) return -1;
  return opened(next<int(const char*, int, mode_t)>("open")(path, flags, mode), flags);
}
int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  if (writes(flags) && refuse_call()) return -1;
  return opened(next<int(const char*, int, mode_t)>("open64")(path, flags, mode), flags);
}
int close(int descriptor) {
  const bool refused = descriptor >= 0 && descriptor < 1024 && written[descriptor].exchange(false) && refuse_call();
  const int error = errno, result = next<int(int)>("close")(descriptor);
  if (!refused) return result;
  errno = error;
  return -1;
}
ssize_t write(int descriptor, const void* data, size_t size) {
  return refuse_call() ? -1 : next<ssize_t(int, const void*, size_t)>("write")(descriptor, data, size);
}
ssize_t writev(int descriptor, const iovec* parts, int count) {
  return refuse_call() ? -1 : next<ssize_t(int, const iovec*, int)>("writev")(descriptor, parts, count);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  return refuse_call() ? -1 : next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(descriptor, data, size, at);
}
int fsync(int descriptor) { return refuse_call() ? -1 : next<int(int)>("fsync")(descriptor); }
int fdatasync(int descriptor) { return refuse_call() ? -1 : next<int(int)>("fdatasync")(descriptor); }
int ftruncate(int descriptor, off_t size) {
  return refuse_call() ? -1 : next<int(int, off_t)>("ftruncate")(descriptor, size);
}
int fchmod(int descriptor, mode_t mode) {
  return refuse_call() ? -1 : next<int(int, mode_t)>("fchmod")(descriptor, mode);
}
int rename(const char* from, const char* to) {
  return refuse_call() ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}
int unlink(const char* path) { return refuse_call() ? -1 : next<int(const char*)>("unlink")(path); }
int mkdir(const char* path, mode_t mode) {
  return refuse_call() ? -1 : next<int(const char*, mode_t)>("mkdir")(path, mode);
}

void* malloc(size_t size) { return refuse_memory() ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return refuse_memory() ? nullptr : __libc_calloc(count, size); }
void* realloc(void* memory, size_t size) { return refuse_memory() ? nullptr : __libc_realloc(memory, size); }
void* memalign(size_t alignment, size_t size) { return refuse_memory() ? nullptr : __libc_memalign(alignment, size); }
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** memory, size_t alignment, size_t size) {
  void* found = memalign(alignment, size);
  if (!found) return ENOMEM;
  *memory = found;
  return 0;
}
void* mmap(void* at, size_t size, int protection, int flags, int descriptor, off_t offset) {
  if (refuse_memory()) return MAP_FAILED;
  return next<void*(void*, size_t, int, int, int, off_t)>("mmap")(at, size, protection, flags, descriptor, offset);
}

}  // extern "C"
