// SPDX-License-Identifier: Apache-2.0
// What a query of an SQLite file finds first, as text.
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <string>

namespace grtx::e2e {

inline std::string first_value(const std::string& path, const std::string& query) {
  sqlite3* database = nullptr;
  sqlite3_stmt* select = nullptr;
  EXPECT_EQ(sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK) << path;
  EXPECT_EQ(sqlite3_prepare_v2(database, query.c_str(), -1, &select, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  std::string value;
  EXPECT_EQ(sqlite3_step(select), SQLITE_ROW) << query;
  if (const unsigned char* text = sqlite3_column_text(select, 0)) value = reinterpret_cast<const char*>(text);
  sqlite3_finalize(select);
  sqlite3_close(database);
  return value;
}

}  // namespace grtx::e2e
