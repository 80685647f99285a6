// SPDX-License-Identifier: Apache-2.0
// The statistics file of a run: {"schema": "grtx.stats/1", "config": {...}, "inputs": {...}, "notes": [...],
// "stats": {...}}.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::sim {

/// {"name": {"value", "unit", "description"}, ...} in the list's order. Integers stay integers; doubles are written in
/// the shortest form that reads back; a value that is not finite becomes null.
nlohmann::ordered_json statistics_object(const modules::StatisticList& list);

/// The list for another process of the program: nothing of it is lost.
nlohmann::ordered_json list_json(const modules::StatisticList& list);
modules::StatisticList list_from_json(const nlohmann::ordered_json& json);

/// The whole document. `host` (what depends on the machine: wall time, memory, speed) comes last in "stats", so that
/// the lines before it are byte-identical for the same inputs.
nlohmann::ordered_json statistics_document(const nlohmann::ordered_json& config,
                                           const std::map<std::string, std::string>& inputs, const ResultNotes& notes,
                                           const modules::StatisticList& statistics, const modules::StatisticList& host,
                                           const nlohmann::ordered_json& over_time = nullptr);

/// Reads such a document. Throws Error for bad JSON, another schema, missing "config", "inputs" or "stats", or bad
/// notes; documents of earlier versions have no notes.
nlohmann::ordered_json read_statistics(const std::string& path);

/// Throws Error unless it is an object of statistics with a number each (null: not finite). place: prefix of their
/// names.
void check_statistics(const nlohmann::ordered_json& statistics, const std::string& path, const std::string& place);

/// Text of such a document, with one line per statistic and per configuration key.
std::string statistics_text(const nlohmann::ordered_json& document);

}  // namespace grtx::sim
