// SPDX-License-Identifier: Apache-2.0
// The reference of all statistics that a run may report, made from the tables with which it reports.
#pragma once

#include <string>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// Statistics of every run: GPU counters and lower bounds. Statistics of the same kind (statistic_kind()) appear once.
modules::StatisticList statistic_kinds();

/// The name under which the reference lists a statistic: the number of an SM, RT unit, channel, frame or bin, and a
/// region, become placeholders in angle brackets.
std::string statistic_kind(const std::string& name);

/// A Markdown table for each group of names.
std::string statistics_reference(const modules::StatisticList& kinds);

}  // namespace grtx::sim
