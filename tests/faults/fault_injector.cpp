// SPDX-License-Identifier: Apache-2.0
// Preloaded by scripts/inject_faults.py, and by nothing else: lets the n-th call of a class fail, counts the calls, or
// records what was written and synced, over a program and all processes that it starts. Only files below one folder
// count. Calls inside the C library (a stream's own write) cannot be seen from outside, so fwrite() to such files is
// written through here.
//
//   GRTX_FAULT_STATE   file of a State, shared by all processes: counts, and the call that fails
//   GRTX_FAULT_FOLDER  absolute path of the folder
//   GRTX_FAULT_LOG     file to which a Record is appended for each change that succeeded; none: no log
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

enum Class : std::uint32_t {
  open_read,
  open_write,
  write_data,
  sync_file,
  rename_file,
  resize,
  remove_file,
  make_folder,
  start_process,
  allocate,
  sqlite,
  classes
};
constexpr std::size_t kSites = 1U << 15;

/// As scripts/inject_faults.py lays it out: little-endian, no padding.
struct State {
  std::uint64_t fail_class, fail_at;         ///< fail_at counts from 1; 0: none
  std::atomic<std::uint64_t> fired;          ///< calls that failed
  std::atomic<std::uint64_t> count[16];      ///< by class
  std::atomic<std::uint64_t> site[kSites];   ///< hash of the place of an allocation; 0: free
  std::atomic<std::uint64_t> first[kSites];  ///< which allocation was its first
};

State* state = nullptr;
char folder[PATH_MAX] = "";
std::size_t folder_length = 0;
int log_file = -1;
bool counting = false;     ///< between the beginning and the end of main()
thread_local bool inside;  ///< one of the functions below is at work
bool sqlite_failed = false;

template <class Function>
Function next(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}
#define NEXT(name) static const auto real = next(&::name, #name)

bool below_folder(const char* absolute) {
  return state != nullptr && std::strncmp(absolute, folder, folder_length) == 0 &&
         (absolute[folder_length] == '/' || absolute[folder_length] == '\0');
}

/// The absolute path; false when it is not below the folder.
bool resolve(const char* path, char* absolute) {
  if (state == nullptr || !counting || inside || path == nullptr) return false;
  if (path[0] == '/') {
    std::snprintf(absolute, PATH_MAX, "%s", path);
  } else {
    char here[PATH_MAX];
    if (::getcwd(here, sizeof here) == nullptr) return false;
    if (std::snprintf(absolute, PATH_MAX, "%s/%s", here, path) >= PATH_MAX) return false;
  }
  return below_folder(absolute);
}

bool resolve(int file, char* absolute) {
  if (state == nullptr || !counting || inside) return false;
  char link[64];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = ::readlink(link, absolute, PATH_MAX - 1);
  if (length <= 0) return false;
  absolute[length] = '\0';
  return below_folder(absolute);
}

/// Counts a call. True when it is the one that fails.
bool fails(Class what, int error) {
  const std::uint64_t number = ++state->count[what];
  if (state->fail_class != what || state->fail_at != number) return false;
  ++state->fired;
  errno = error;
  return true;
}

enum Kind : std::uint32_t { created = 1, wrote, resized, synced, folder_synced, renamed, removed, folder_made };
struct Record {
  std::uint32_t kind, path, other, bytes;  ///< lengths of what follows
  std::uint64_t inode, offset;
};

void record(Kind kind, std::uint64_t inode, std::uint64_t offset, const char* path, const char* other,
            const void* bytes, std::size_t count) {
  if (log_file < 0) return;
  const int kept = errno;
  Record r{kind,
           static_cast<std::uint32_t>(std::strlen(path)),
           static_cast<std::uint32_t>(std::strlen(other)),
           static_cast<std::uint32_t>(count),
           inode,
           offset};
  const iovec parts[] = {{&r, sizeof r},
                         {const_cast<char*>(path), r.path},
                         {const_cast<char*>(other), r.other},
                         {const_cast<void*>(bytes), count}};
  ::syscall(SYS_writev, log_file, parts, 4);  // appended in one piece
  errno = kept;
}

std::uint64_t inode_of(int file) {
  struct stat status {};
  return ::fstat(file, &status) == 0 ? status.st_ino : 0;
}

template <class Open>
int opened(const char* path, int flags, const Open& open) {
  char absolute[PATH_MAX];
  if (!resolve(path, absolute)) return open();
  const bool writes = (flags & O_ACCMODE) != O_RDONLY;
  if (fails(writes ? open_write : open_read, EACCES)) return -1;
  struct stat before {};
  const bool existed = ::stat(absolute, &before) == 0;
  const int file = open();
  if (file >= 0 && writes) {
    if (!existed) record(created, inode_of(file), 0, absolute, "", nullptr, 0);
    if (existed && (flags & O_TRUNC) != 0 && S_ISREG(before.st_mode)) {
      record(resized, before.st_ino, 0, absolute, "", nullptr, 0);
    }
  }
  return file;
}

template <class Write>
ssize_t written(int file, const void* bytes, std::int64_t offset, const Write& write) {
  char absolute[PATH_MAX];
  if (!resolve(file, absolute)) return write();
  if (fails(write_data, ENOSPC)) return -1;
  if (offset < 0)
    offset = (::fcntl(file, F_GETFL) & O_APPEND) != 0 ? ::lseek(file, 0, SEEK_END) : ::lseek(file, 0, SEEK_CUR);
  const ssize_t done = write();
  if (done > 0) {
    record(wrote, inode_of(file), static_cast<std::uint64_t>(offset), absolute, "", bytes,
           static_cast<std::size_t>(done));
  }
  return done;
}

template <class Sync>
int synchronised(int file, const Sync& sync) {
  char absolute[PATH_MAX];
  if (!resolve(file, absolute)) return sync();
  if (fails(sync_file, EIO)) return -1;
  const int result = sync();
  struct stat status {};
  if (result == 0 && ::fstat(file, &status) == 0) {
    record(S_ISDIR(status.st_mode) ? folder_synced : synced, status.st_ino, 0, absolute, "", nullptr, 0);
  }
  return result;
}

template <class Resize>
int cut(int file, off_t size, const Resize& resize_it) {
  char absolute[PATH_MAX];
  if (!resolve(file, absolute)) return resize_it();
  if (fails(resize, EIO)) return -1;
  const int result = resize_it();
  if (result == 0) record(resized, inode_of(file), static_cast<std::uint64_t>(size), absolute, "", nullptr, 0);
  return result;
}

template <class Remove>
int taken_away(const char* path, const Remove& remove_it) {
  char absolute[PATH_MAX];
  if (!resolve(path, absolute)) return remove_it();
  if (fails(remove_file, EIO)) return -1;
  const int result = remove_it();
  if (result == 0) record(removed, 0, 0, absolute, "", nullptr, 0);
  return result;
}

/// A place of an allocation, the same in every process: module and offset.
void note_site(const void* place, std::uint64_t number) {
  Dl_info info{};
  inside = true;
  if (::dladdr(place, &info) == 0) info = {};
  inside = false;
  std::uint64_t hash = static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(place) -
                                                  reinterpret_cast<std::uintptr_t>(info.dli_fbase));
  for (const char* c = info.dli_fname == nullptr ? "" : info.dli_fname; *c != '\0'; ++c)
    hash = hash * 1099511628211U + static_cast<unsigned char>(*c);
  hash |= 1;
  for (std::size_t i = (hash >> 1) % kSites, tries = 0; tries < kSites; i = (i + 1) % kSites, ++tries) {
    std::uint64_t found = state->site[i].load();
    if (found == 0 && state->site[i].compare_exchange_strong(found, hash)) {
      state->first[i] = number;
      return;
    }
    if (found == hash) return;
  }
}

bool allocation_fails(const void* place) {
  if (state == nullptr || !counting || inside) return false;
  const std::uint64_t number = ++state->count[allocate];
  if (state->fail_class == classes) {  // looks for places
    note_site(place, number);
    return false;
  }
  if (state->fail_class != allocate || state->fail_at != number) return false;
  ++state->fired;
  errno = ENOMEM;
  return true;
}

bool sqlite_fails() {
  if (state == nullptr || !counting) return false;
  return fails(sqlite, EIO) && (sqlite_failed = true);
}

__attribute__((constructor)) void begin() {
  const char* const path = std::getenv("GRTX_FAULT_STATE");
  const char* const below = std::getenv("GRTX_FAULT_FOLDER");
  if (path == nullptr || below == nullptr) return;
  const auto file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC, 0));
  if (file < 0) return;
  void* const at = ::mmap(nullptr, sizeof(State), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::syscall(SYS_close, file);
  if (at == MAP_FAILED) return;
  folder_length = static_cast<std::size_t>(std::snprintf(folder, sizeof folder, "%s", below));
  state = static_cast<State*>(at);
  if (const char* const log = std::getenv("GRTX_FAULT_LOG")) {
    log_file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600));
    const int high = ::fcntl(log_file, F_DUPFD_CLOEXEC, 900);  // out of the program's way
    if (high >= 0) {
      ::syscall(SYS_close, log_file);
      log_file = high;
    }
  }
}

using Main = int (*)(int, char**, char**);
Main program_main = nullptr;
int counted_main(int argc, char** argv, char** environment) {
  counting = true;
  const int code = program_main(argc, argv, environment);
  counting = false;
  return code;
}

}  // namespace

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(), void (*rtld)(), void* end) {
  using Start = int (*)(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  program_main = main;
  return reinterpret_cast<Start>(::dlsym(RTLD_NEXT, "__libc_start_main"))(counted_main, argc, argv, init, fini, rtld,
                                                                          end);
}

void* malloc(std::size_t size) { return allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) {
  return allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  return size != 0 && allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  return allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  if (allocation_fails(__builtin_return_address(0))) return ENOMEM;
  *result = __libc_memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}

int open(const char* path, int flags, ...) {
  NEXT(open);
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return opened(path, flags, [&] { return real(path, flags, mode); });
}
int open64(const char* path, int flags, ...) {
  NEXT(open64);
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return opened(path, flags, [&] { return real(path, flags, mode); });
}
FILE* fopen(const char* path, const char* mode) {
  NEXT(fopen);
  FILE* stream = nullptr;
  const int flags = mode[0] == 'r' && std::strchr(mode, '+') == nullptr ? O_RDONLY
                    : mode[0] == 'w'                                    ? O_WRONLY | O_TRUNC
                                                                        : O_RDWR;
  opened(path, flags, [&] { return (stream = real(path, mode)) == nullptr ? -1 : ::fileno(stream); });
  return stream;
}
FILE* fopen64(const char* path, const char* mode) {
  NEXT(fopen64);
  FILE* stream = nullptr;
  const int flags = mode[0] == 'r' && std::strchr(mode, '+') == nullptr ? O_RDONLY
                    : mode[0] == 'w'                                    ? O_WRONLY | O_TRUNC
                                                                        : O_RDWR;
  opened(path, flags, [&] { return (stream = real(path, mode)) == nullptr ? -1 : ::fileno(stream); });
  return stream;
}
ssize_t write(int file, const void* bytes, std::size_t count) {
  NEXT(write);
  return written(file, bytes, -1, [&] { return real(file, bytes, count); });
}
ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t offset) {
  NEXT(pwrite);
  return written(file, bytes, offset, [&] { return real(file, bytes, count, offset); });
}
ssize_t pwrite64(int file, const void* bytes, std::size_t count, off64_t offset) {
  NEXT(pwrite64);
  return written(file, bytes, offset, [&] { return real(file, bytes, count, offset); });
}
ssize_t writev(int file, const iovec* parts, int count) {
  // One call each part, so that the log has the bytes.
  ssize_t all = 0;
  for (int i = 0; i < count; ++i) {
    const ssize_t done = ::write(file, parts[i].iov_base, parts[i].iov_len);
    if (done < 0) return all > 0 ? all : done;
    all += done;
    if (static_cast<std::size_t>(done) < parts[i].iov_len) break;
  }
  return all;
}
std::size_t fwrite(const void* bytes, std::size_t size, std::size_t count, FILE* stream) {
  NEXT(fwrite);
  char absolute[PATH_MAX];
  const int file = ::fileno(stream);
  if (file <= 2 || size == 0 || !resolve(file, absolute)) return real(bytes, size, count, stream);
  const std::size_t all = size * count;
  for (std::size_t done = 0; done < all;) {
    const ssize_t now = ::write(file, static_cast<const char*>(bytes) + done, all - done);
    if (now < 0) return done / size;
    done += static_cast<std::size_t>(now);
  }
  return count;
}
int fsync(int file) {
  NEXT(fsync);
  return synchronised(file, [&] { return real(file); });
}
int fdatasync(int file) {
  NEXT(fdatasync);
  return synchronised(file, [&] { return real(file); });
}
int ftruncate(int file, off_t size) noexcept {
  NEXT(ftruncate);
  return cut(file, size, [&] { return real(file, size); });
}
int ftruncate64(int file, off64_t size) noexcept {
  NEXT(ftruncate64);
  return cut(file, size, [&] { return real(file, size); });
}
int rename(const char* from, const char* to) noexcept {
  NEXT(rename);
  char source[PATH_MAX], target[PATH_MAX];
  if (!resolve(from, source) || !resolve(to, target)) return real(from, to);
  if (fails(rename_file, EIO)) return -1;
  const int result = real(from, to);
  if (result == 0) record(renamed, 0, 0, source, target, nullptr, 0);
  return result;
}
int remove(const char* path) noexcept {
  NEXT(remove);
  return taken_away(path, [&] { return real(path); });
}
int unlink(const char* path) noexcept {
  NEXT(unlink);
  return taken_away(path, [&] { return real(path); });
}
int rmdir(const char* path) noexcept {
  NEXT(rmdir);
  return taken_away(path, [&] { return real(path); });
}
int unlinkat(int at, const char* path, int flags) noexcept {
  NEXT(unlinkat);
  char absolute[PATH_MAX];
  if (at != AT_FDCWD && path[0] != '/' && resolve(at, absolute)) {
    char whole[PATH_MAX + 256];
    std::snprintf(whole, sizeof whole, "%s/%s", absolute, path);
    return taken_away(whole, [&] { return real(at, path, flags); });
  }
  return taken_away(path, [&] { return real(at, path, flags); });
}
int mkdir(const char* path, mode_t mode) noexcept {
  NEXT(mkdir);
  char absolute[PATH_MAX];
  if (!resolve(path, absolute)) return real(path, mode);
  if (fails(make_folder, ENOSPC)) return -1;
  const int result = real(path, mode);
  if (result == 0) record(folder_made, 0, 0, absolute, "", nullptr, 0);
  return result;
}
pid_t fork() noexcept {
  NEXT(fork);
  if (state != nullptr && counting && fails(start_process, EAGAIN)) return -1;
  return real();
}

// SQLite's interface, as far as the project calls it. Its types are opaque here.
constexpr int kIoError = 10;  // SQLITE_IOERR
const char* sqlite3_errmsg(void* database) {
  static const auto real = reinterpret_cast<const char* (*)(void*)>(::dlsym(RTLD_NEXT, "sqlite3_errmsg"));
  if (sqlite_failed) {
    sqlite_failed = false;
    return "disk I/O error";
  }
  return real(database);
}
int sqlite3_step(void* statement) {
  static const auto real = reinterpret_cast<int (*)(void*)>(::dlsym(RTLD_NEXT, "sqlite3_step"));
  return sqlite_fails() ? kIoError : real(statement);
}
int sqlite3_prepare_v2(void* database, const char* sql, int count, void** statement, const char** rest) {
  using Prepare = int (*)(void*, const char*, int, void**, const char**);
  static const auto real = reinterpret_cast<Prepare>(::dlsym(RTLD_NEXT, "sqlite3_prepare_v2"));
  if (!sqlite_fails()) return real(database, sql, count, statement, rest);
  *statement = nullptr;
  return kIoError;
}
int sqlite3_exec(void* database, const char* sql, int (*call)(void*, int, char**, char**), void* value, char** error) {
  using Execute = int (*)(void*, const char*, int (*)(void*, int, char**, char**), void*, char**);
  static const auto real = reinterpret_cast<Execute>(::dlsym(RTLD_NEXT, "sqlite3_exec"));
  return sqlite_fails() ? kIoError : real(database, sql, call, value, error);
}
int sqlite3_open_v2(const char* path, void** database, int flags, const char* system) {
  using Open = int (*)(const char*, void**, int, const char*);
  static const auto real = reinterpret_cast<Open>(::dlsym(RTLD_NEXT, "sqlite3_open_v2"));
  const int result = real(path, database, flags, system);
  return sqlite_fails() ? kIoError : result;
}
int sqlite3_bind_text64(void* statement, int index, const char* text, std::uint64_t count, void (*end)(void*),
                        unsigned char encoding) {
  using Bind = int (*)(void*, int, const char*, std::uint64_t, void (*)(void*), unsigned char);
  static const auto real = reinterpret_cast<Bind>(::dlsym(RTLD_NEXT, "sqlite3_bind_text64"));
  return sqlite_fails() ? kIoError : real(statement, index, text, count, end, encoding);
}

}  // extern "C"

namespace {
[[noreturn]] void without_memory() {
  if (const std::new_handler handler = std::get_new_handler()) handler();
  throw std::bad_alloc();
}
}  // namespace

// The library's own would come from libstdc++, whose one call of malloc() hides the place.
void* operator new(std::size_t size) {
  if (!allocation_fails(__builtin_return_address(0))) {
    if (void* const memory = __libc_malloc(size == 0 ? 1 : size)) return memory;
  }
  without_memory();
}
void* operator new[](std::size_t size) {
  if (!allocation_fails(__builtin_return_address(0))) {
    if (void* const memory = __libc_malloc(size == 0 ? 1 : size)) return memory;
  }
  without_memory();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocation_fails(__builtin_return_address(0)) ? nullptr : __libc_malloc(size == 0 ? 1 : size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (!allocation_fails(__builtin_return_address(0))) {
    if (void* const memory = __libc_memalign(static_cast<std::size_t>(alignment), size == 0 ? 1 : size)) return memory;
  }
  without_memory();
}
