// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/sqlite.h"

#include <sqlite3.h>

#include <exception>
#include <filesystem>
#include <new>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"

namespace grtx::explore {

namespace {

/// Makes names that SQLite treats specially ("", ":..." and "file:...") plain file names.
std::string plain_name(const std::string& path) {
  if (path.empty()) throw Error("database", "", "needs a name");
  return path.front() == '/' ? path : "./" + path;
}

}  // namespace

Sqlite::Sqlite(const std::string& path, Open how) : path_(path) {
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown)) check_regular_file(path);
  open(plain_name(path), how == Open::read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
}

Sqlite::Sqlite() : path_("database in memory") { open(":memory:", SQLITE_OPEN_READWRITE); }

void Sqlite::open(const std::string& name, int flags) {
  if (sqlite3_open_v2(name.c_str(), &handle_, flags, nullptr) != SQLITE_OK) {
    if (handle_ == nullptr || sqlite3_errcode(handle_) == SQLITE_NOMEM) {
      sqlite3_close(handle_);
      throw std::bad_alloc();
    }
    const std::string why = sqlite3_errmsg(handle_);
    sqlite3_close(handle_);
    throw Error(path_, "", why);
  }
  sqlite3_busy_timeout(handle_, 10000);  // ms; a reader may lock it briefly
}

Sqlite::~Sqlite() { sqlite3_close(handle_); }

// A damaged page may make SQLite ask for more memory than there is.
void Sqlite::fail() const {
  const std::string why = sqlite3_errmsg(handle_);
  if (sqlite3_errcode(handle_) != SQLITE_NOMEM) throw Error(path_, "", why);
  if (sound()) throw std::bad_alloc();
  throw Error(path_, "", "database disk image is malformed: it asks for more memory than there is");
}

bool Sqlite::sound() const {
  sqlite3* again = nullptr;
  bool found = false;
  if (sqlite3_open_v2(plain_name(path_).c_str(), &again, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK) {
    const auto not_ok = [](void* damaged, int, char** columns, char**) {
      *static_cast<bool*>(damaged) = columns[0] == nullptr || std::string_view(columns[0]) != "ok";
      return 0;
    };
    const int code = sqlite3_exec(again, "PRAGMA quick_check(1)", not_ok, &found, nullptr);
    found = found || code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
    if (code == SQLITE_NOMEM) {  // although memory is available: the file is damaged
      void* some = sqlite3_malloc(16 << 20);
      found = some != nullptr;
      sqlite3_free(some);
    }
  }
  sqlite3_close(again);
  return !found;
}

void Sqlite::execute(const std::string& sql) {
  if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

SqliteStatement::SqliteStatement(Sqlite& database, const std::string& sql) : database_(database) {
  if (sqlite3_prepare_v2(database.handle_, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) database_.fail();
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(statement_); }

SqliteStatement& SqliteStatement::bind(int index, const std::string& text) {
  if (sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8) != SQLITE_OK) {
    database_.fail();
  }
  return *this;
}

SqliteStatement& SqliteStatement::bind(int index, std::int64_t value) {
  if (sqlite3_bind_int64(statement_, index, value) != SQLITE_OK) database_.fail();
  return *this;
}

SqliteStatement& SqliteStatement::bind(int index, double value) {
  if (sqlite3_bind_double(statement_, index, value) != SQLITE_OK) database_.fail();
  return *this;
}

bool SqliteStatement::step() {
  const int result = sqlite3_step(statement_);
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}

void SqliteStatement::run() {
  while (step()) {
  }
  reset();
}

void SqliteStatement::reset() { sqlite3_reset(statement_); }

std::string SqliteStatement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return bytes == nullptr ? "" : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}

std::int64_t SqliteStatement::integer(int column) const { return sqlite3_column_int64(statement_, column); }

double SqliteStatement::real(int column) const { return sqlite3_column_double(statement_, column); }

bool SqliteStatement::null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

bool SqliteStatement::is_number(int column) const {
  const int type = sqlite3_column_type(statement_, column);
  return type == SQLITE_INTEGER || type == SQLITE_FLOAT;
}

SqliteTransaction::~SqliteTransaction() {
  if (committed_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const std::exception&) {  // also out of memory: SQLite rolls back when the database is next opened
  }
}

}  // namespace grtx::explore
