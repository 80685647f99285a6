# SPDX-License-Identifier: Apache-2.0
# What `grtx report` and `grtx ray` put into their pages, linked into grtx_report (report_assets): style, script, the paper's
# figures and, unless GRTX_REPORT_CHARTS=OFF, the chart library. npm fetches that once a build folder; a page needs no
# network.
option(GRTX_REPORT_CHARTS "Charts in the reports of grtx (needs npm when building); OFF leaves their tables" ON)

set(web ${PROJECT_SOURCE_DIR}/report/page/web)
set(GRTX_CHARTS_FOLDER ${PROJECT_BINARY_DIR}/charts)
set(bundle ${GRTX_CHARTS_FOLDER}/charts.js)
file(MAKE_DIRECTORY ${GRTX_CHARTS_FOLDER})
if(GRTX_REPORT_CHARTS)
  find_program(NPM_PROGRAM npm)
  if(NOT NPM_PROGRAM)
    message(FATAL_ERROR "The charts of grtx report need npm (Debian: apt-get install npm, or "
                        "scripts/install_dependencies.sh). With -DGRTX_REPORT_CHARTS=OFF reports have tables only.")
  endif()
  add_custom_command(
    OUTPUT ${bundle}
    COMMAND ${CMAKE_COMMAND} -DNPM=${NPM_PROGRAM} -DWEB=${web} -DFOLDER=${GRTX_CHARTS_FOLDER} -DOUTPUT=${bundle}
            -P ${PROJECT_SOURCE_DIR}/cmake/bundle_charts.cmake
    DEPENDS ${web}/package.json ${web}/package-lock.json ${PROJECT_SOURCE_DIR}/cmake/bundle_charts.cmake
    COMMENT "Fetching the chart library with npm"
    VERBATIM)
else()
  set(bundle ${GRTX_CHARTS_FOLDER}/none.js)  # not the other's name: the option may be turned on again
  file(GENERATE OUTPUT ${bundle} CONTENT "")
endif()

set(assets_source ${CMAKE_CURRENT_BINARY_DIR}/report_assets.S)
set(GRTX_ASSETS "")
set(ray_web ${PROJECT_SOURCE_DIR}/report/ray/web)
set(ray_script ${PROJECT_BINARY_DIR}/ray_script.js)
file(GLOB ray_modules CONFIGURE_DEPENDS ${ray_web}/*.js)
add_custom_command(
  OUTPUT ${ray_script}
  COMMAND ${CMAKE_COMMAND} -DFOLDER=${ray_web} -DOUTPUT=${ray_script}
          -P ${PROJECT_SOURCE_DIR}/cmake/bundle_script.cmake
  DEPENDS ${ray_modules} ${PROJECT_SOURCE_DIR}/cmake/bundle_script.cmake
  COMMENT "Joining the script of grtx ray"
  VERBATIM)
foreach(asset "charts=${bundle}" "style=${web}/report.css" "script=${web}/report.js"
              "export=${web}/export.js" "explore=${web}/explore.js" "explorecharts=${web}/explore_charts.js"
              "raystyle=${ray_web}/ray.css" "rayscript=${ray_script}"
              "paper=${PROJECT_SOURCE_DIR}/report/page/paper_targets.toml")
  string(REGEX MATCH "^([a-z]+)=(.*)$" matched ${asset})
  string(APPEND GRTX_ASSETS
         ".global grtx_asset_${CMAKE_MATCH_1}\n.global grtx_asset_${CMAKE_MATCH_1}_end\n"
         "grtx_asset_${CMAKE_MATCH_1}:\n.incbin \"${CMAKE_MATCH_2}\"\ngrtx_asset_${CMAKE_MATCH_1}_end:\n.byte 0\n")
  list(APPEND asset_files ${CMAKE_MATCH_2})
endforeach()
file(CONFIGURE OUTPUT ${assets_source} @ONLY
     CONTENT ".section .rodata\n@GRTX_ASSETS@.section .note.GNU-stack,\"\",%progbits\n")
set_source_files_properties(${assets_source} PROPERTIES OBJECT_DEPENDS "${asset_files}")
set(report_assets ${assets_source})
