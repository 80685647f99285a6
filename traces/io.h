// Transitional: the three parts have headers of their own.
#pragma once

#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
