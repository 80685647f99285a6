# SPDX-License-Identifier: Apache-2.0
# A source archive has no .git: its program names the commit that git archive wrote into cmake/commit.txt.
# cmake -DSOURCE=... -DFOLDER=... -P archived_commit.cmake
function(stamp_of line out)
  file(WRITE ${FOLDER}/cmake/commit.txt "${line}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE=${FOLDER} -DOUTPUT=${FOLDER}/stamp.cpp -DCOMPILER=C
                          -P ${SOURCE}/cmake/build_stamp.cmake COMMAND_ERROR_IS_FATAL ANY)
  file(READ ${FOLDER}/stamp.cpp text)
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${FOLDER})
file(READ ${SOURCE}/cmake/commit.txt here)
if(NOT here MATCHES "Format")
  set(here "$Format:%h$")  # this tree is an archive itself
endif()
stamp_of("0123456789ab" archived)
stamp_of("${here}" plain)
if(NOT archived MATCHES "kCommit = \"0123456789ab\"")
  message(FATAL_ERROR "the archive's commit is not named: ${archived}")
endif()
if(NOT plain MATCHES "kCommit = \"unknown\"")
  message(FATAL_ERROR "a copy without git or archive names a commit: ${plain}")
endif()
