# The motion page and the live page (viewer/, TypeScript) are bundled to viewer/dist by npm and taken into the library.
# A tree that carries viewer/dist but has no npm is built with the page as it is.
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
set(page ${viewer}/dist/page.html)
set(live_page ${viewer}/dist/live.html)
find_program(NPM npm)
if(NPM)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*)
  set(viewer_packages ${viewer}/node_modules/.package-lock.json)
  add_custom_command(OUTPUT ${viewer_packages}
    COMMAND ${NPM} ci --no-audit --no-fund --silent COMMAND ${CMAKE_COMMAND} -E touch ${viewer_packages}
    DEPENDS ${viewer}/package-lock.json WORKING_DIRECTORY ${viewer} COMMENT "Fetching the page's packages" VERBATIM)
  add_custom_command(OUTPUT ${page} ${live_page} COMMAND ${NPM} run --silent build
    DEPENDS ${viewer_sources} ${viewer}/build.mjs ${viewer_packages}
    WORKING_DIRECTORY ${viewer} COMMENT "Bundling the pages" VERBATIM)
elseif(NOT EXISTS ${page} OR NOT EXISTS ${live_page})
  message(FATAL_ERROR "viewer/dist/page.html or live.html is missing and npm, which builds it, was not found: "
    "install nodejs and npm (Debian: apt-get install nodejs npm), or build the page elsewhere with "
    "`cd viewer && npm ci && npm run build` and copy viewer/dist here")
endif()
set_source_files_properties(inhabit/view/page_template.cpp PROPERTIES
  OBJECT_DEPENDS ${page} SKIP_PRECOMPILE_HEADERS ON COMPILE_DEFINITIONS "INHABIT_PAGE_TEMPLATE=\"${page}\"")
set_source_files_properties(inhabit/serve/live_template.cpp PROPERTIES
  OBJECT_DEPENDS ${live_page} SKIP_PRECOMPILE_HEADERS ON COMPILE_DEFINITIONS "INHABIT_LIVE_TEMPLATE=\"${live_page}\"")
