# SPDX-License-Identifier: Apache-2.0
# When installing: the public headers (docs/api/public_headers.txt) of FOLDERS, and the headers that these include.
# SOURCE: the top of the sources. DESTINATION: the folder that becomes "grtx/" of an include.
cmake_policy(PUSH)
cmake_policy(SET CMP0057 NEW)  # IN_LIST
file(STRINGS ${SOURCE}/docs/api/public_headers.txt todo REGEX "^[^#]")
set(headers "")
while(todo)
  list(POP_FRONT todo header)
  string(REGEX MATCH "^[^/]+" folder ${header})
  if(header IN_LIST headers OR NOT folder IN_LIST FOLDERS)
    continue()
  endif()
  list(APPEND headers ${header})
  file(STRINGS ${SOURCE}/${header} includes REGEX "^#include \"grtx/")
  list(TRANSFORM includes REPLACE "^#include \"grtx/(.*)\".*" "\\1")
  list(APPEND todo ${includes})
endwhile()
list(SORT headers)
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  file(INSTALL ${SOURCE}/${header} DESTINATION ${DESTINATION}/${folder})
endforeach()
cmake_policy(POP)
