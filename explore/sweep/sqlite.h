// SPDX-License-Identifier: Apache-2.0
// RAII wrappers of SQLite; failures throw Error naming the database.
#pragma once

#include <cstdint>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace grtx::explore {

class Sqlite {
 public:
  enum class Open { read_only, create };
  /// Opens the file `path`. Special names of SQLite, such as ":memory:", are treated as file names.
  Sqlite(const std::string& path, Open how);
  /// An empty database in memory.
  Sqlite();
  ~Sqlite();
  Sqlite(const Sqlite&) = delete;
  Sqlite& operator=(const Sqlite&) = delete;

  void execute(const std::string& sql);
  const std::string& path() const { return path_; }

 private:
  friend class SqliteStatement;
  void open(const std::string& name, int flags);
  [[noreturn]] void fail() const;
  /// Returns false if SQLite finds the file damaged.
  bool sound() const;
  std::string path_;
  sqlite3* handle_ = nullptr;
};

class SqliteStatement {
 public:
  SqliteStatement(Sqlite& database, const std::string& sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  /// Parameters are numbered from 1.
  SqliteStatement& bind(int index, const std::string& text);
  SqliteStatement& bind(int index, std::int64_t value);
  SqliteStatement& bind(int index, double value);
  /// Advances to the next row; returns false after the last one.
  bool step();
  /// Runs a statement that returns no rows, then resets it for new parameters.
  void run();
  void reset();

  /// Columns are numbered from 0. NULL is read as "" or 0.
  std::string text(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  bool null(int column) const;
  /// False for text and blobs, which real() and integer() read as 0.
  bool is_number(int column) const;

 private:
  Sqlite& database_;
  sqlite3_stmt* statement_ = nullptr;
};

/// A transaction, rolled back unless committed. Reads within it see one consistent state.
class SqliteTransaction {
 public:
  enum class Kind { write, read };
  explicit SqliteTransaction(Sqlite& database, Kind kind = Kind::write) : database_(database) {
    database_.execute(kind == Kind::write ? "BEGIN IMMEDIATE" : "BEGIN");
  }
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;
  void commit() {
    database_.execute("COMMIT");
    committed_ = true;
  }

 private:
  Sqlite& database_;
  bool committed_ = false;
};

}  // namespace grtx::explore
