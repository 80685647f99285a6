// The reference of all statistics: what a run may report, from the tables with which it reports.
#pragma once

#include <string>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// What every engine's run has: the counters of the GPU and the lower bounds. Rows that there are several of, alike,
/// appear once: see statistic_kind().
modules::StatisticList statistic_kinds();

/// The name under which the reference lists a statistic of a run: SM, channel, bin and region in angle brackets.
std::string statistic_kind(const std::string& name);

/// A Markdown table for each group of names.
std::string statistics_reference(const modules::StatisticList& kinds);

}  // namespace grtx::sim
