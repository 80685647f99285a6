# SPDX-License-Identifier: Apache-2.0
# Run with cmake -P: installs the packages that WEB/package-lock.json names into FOLDER and joins the chart library's
# files, each under its licence, into OUTPUT. Scripts of packages are not run.
file(COPY ${WEB}/package.json ${WEB}/package-lock.json DESTINATION ${FOLDER})
execute_process(
  COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --loglevel=error
  WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE failed OUTPUT_VARIABLE log ERROR_VARIABLE log)
if(failed)
  message(FATAL_ERROR "npm could not fetch the chart library of grtx report (${failed}); -DGRTX_REPORT_CHARTS=OFF "
                      "builds without:\n${log}")
endif()
set(text "")
foreach(package vega vega-lite vega-embed)
  set(from ${FOLDER}/node_modules/${package})
  file(READ ${from}/package.json description)
  string(JSON version GET ${description} version)
  file(READ ${from}/LICENSE licence)
  file(READ ${from}/build/${package}.min.js code)
  string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" code "${code}")
  if(code MATCHES "</[sS][cC][rR][iI][pP][tT]")
    message(FATAL_ERROR "${package} holds the end of a script element: it cannot be put into a page as it is")
  endif()
  string(APPEND text "/* ${package} ${version}\n${licence}*/\n${code}\n")
endforeach()
file(WRITE ${OUTPUT}.partial "${text}")
file(RENAME ${OUTPUT}.partial ${OUTPUT})
