// SPDX-License-Identifier: Apache-2.0
// The reference of all statistics that a run may report, made from the tables with which it reports.
#pragma once

#include <string>

#include "grtx/modules/kernel/declare.h"

namespace grtx::sim {

/// Statistics of every run: GPU counters and lower bounds. Of those with one name in the reference one is there.
modules::StatisticList all_statistics();

/// The name under which the reference lists a statistic: the number of an SM, RT unit, channel, frame or bin, and a
/// region, become placeholders in angle brackets.
std::string reference_name(const std::string& name);
/// A statistic of this name as it is declared: its unit and kind; nullptr: none is.
const modules::Statistic* declared_statistic(const std::string& name);
/// Whether a statistic is of one SM, RT unit, channel or frame, and not of the whole machine.
bool is_of_one_part(const std::string& name);

/// A Markdown table for each group of names.
std::string statistics_reference(const modules::StatisticList& all);

}  // namespace grtx::sim
