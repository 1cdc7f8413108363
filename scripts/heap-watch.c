/* Watches the memory of the program that it is loaded into (LD_PRELOAD), for scripts/view-soak: writes a line four times
 * a second into the file that HEAP_WATCH_LOG names: the round of the script, then bytes: of the heap in use, of the heap
 * free, and resident. The round is the number of files HEAP_WATCH_ROUNDS (a printf pattern of one %d) that there are.
 * HEAP_WATCH_LEAK bytes are lost with every round, to show that the script finds a leak. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <malloc.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static unsigned long long size_in(const char* text, const char* kind) {
  const char* at = strstr(text, kind);
  at = at ? strstr(at, "size=\"") : NULL;
  return at ? strtoull(at + 6, NULL, 10) : 0;
}

/* Of glibc's heap, all arenas: what malloc_info() sums up behind the last of them. */
static void ask_glibc(unsigned long long* in_use, unsigned long long* unused) {
  char* text = NULL;
  size_t length = 0;
  FILE* stream = open_memstream(&text, &length);
  if (!stream) return;
  malloc_info(0, stream);
  fclose(stream);
  const char* sums = text;
  for (const char* next; (next = strstr(sums, "</heap>")) != NULL;) sums = next + 7;
  *unused = size_in(sums, "type=\"fast\"") + size_in(sums, "type=\"rest\"");
  *in_use = size_in(sums, "<system type=\"current\"") + size_in(sums, "type=\"mmap\"") - *unused;
  free(text);
}

static unsigned long long resident(void) {
  unsigned long long size = 0, pages = 0;
  FILE* file = fopen("/proc/self/statm", "r");
  if (!file) return 0;
  if (fscanf(file, "%llu %llu", &size, &pages) != 2) pages = 0;
  fclose(file);
  return pages * (unsigned long long)sysconf(_SC_PAGESIZE);
}

static void* watch(void* log) {
  const char* rounds = getenv("HEAP_WATCH_ROUNDS");
  const size_t leak = getenv("HEAP_WATCH_LEAK") ? strtoull(getenv("HEAP_WATCH_LEAK"), NULL, 10) : 0;
  /* The sanitizers have a heap of their own. */
  size_t (*const allocated)(void) = (size_t(*)(void))dlsym(RTLD_DEFAULT, "__sanitizer_get_current_allocated_bytes");
  size_t (*const unmapped)(void) = (size_t(*)(void))dlsym(RTLD_DEFAULT, "__sanitizer_get_free_bytes");
  int round = 0;
  for (;; usleep(250000)) {
    char name[4096];
    while (rounds && snprintf(name, sizeof name, rounds, round) > 0 && access(name, F_OK) == 0) {
      ++round;
      if (leak) memset(malloc(leak), 1, leak);
    }
    unsigned long long in_use = 0, unused = 0;
    if (allocated && unmapped) {
      in_use = allocated();
      unused = unmapped();
    } else {
      ask_glibc(&in_use, &unused);
    }
    fprintf(log, "%d %llu %llu %llu\n", round, in_use, unused, resident());
    fflush(log);
  }
  return NULL;
}

__attribute__((constructor)) static void start(void) {
  const char* path = getenv("HEAP_WATCH_LOG");
  FILE* log = path ? fopen(path, "w") : NULL;
  pthread_t thread;
  if (log && pthread_create(&thread, NULL, watch, log) == 0) pthread_detach(thread);
}
