// Which model a figure is of. It rises when records of results change: scripts/model_version.py raise TEXT.
#pragma once

namespace grtx::sim {

/// What changed with each version: docs/results/data/model_versions.csv, which CI holds against the golden records.
inline constexpr int kModelVersion = 7;

}  // namespace grtx::sim
