# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, the source behind apps/grtx/build_stamp.h, if it would differ: cmake -DSOURCE=... -DOUTPUT=...
# -DCOMPILER=... -P build_stamp.cmake. Each build runs it, since a commit changes no file that a build looks at.
set(commit unknown)
file(STRINGS ${SOURCE}/cmake/commit.txt archived LIMIT_COUNT 1)
if(NOT archived MATCHES "Format")  # git archive put the hash there (.gitattributes)
  set(commit ${archived})
elseif(EXISTS ${SOURCE}/.git)  # not of a repository that merely lies around this folder
  find_package(Git QUIET)
  if(Git_FOUND)
    execute_process(COMMAND ${GIT_EXECUTABLE} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
    if(NOT failed)
      set(commit ${described})
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "grtx/apps/grtx/build_stamp.h"

const char* const grtx::apps::kCommit = "@commit@";
const char* const grtx::apps::kCompiler = "@COMPILER@";
]])
