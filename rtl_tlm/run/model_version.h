// SPDX-License-Identifier: Apache-2.0
// Version of the model behind a figure. It rises when recorded results change: scripts/model_version.py raise TEXT.
#pragma once

namespace grtx::sim {

/// Changes of each version: docs/results/data/model_versions.csv, which CI checks against the golden records.
inline constexpr int kModelVersion = 10;

}  // namespace grtx::sim
