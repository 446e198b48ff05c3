# The motion page (viewer/, TypeScript) is bundled to viewer/dist/page.html by npm and taken into the library.
# A tree that carries viewer/dist/page.html but has no npm is built with the page as it is.
set(viewer ${PROJECT_SOURCE_DIR}/viewer)
set(page ${viewer}/dist/page.html)
find_program(NPM npm)
if(NPM)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${viewer}/src/*)
  set(viewer_packages ${viewer}/node_modules/.package-lock.json)
  add_custom_command(OUTPUT ${viewer_packages}
    COMMAND ${NPM} ci --no-audit --no-fund --silent COMMAND ${CMAKE_COMMAND} -E touch ${viewer_packages}
    DEPENDS ${viewer}/package-lock.json WORKING_DIRECTORY ${viewer} COMMENT "Fetching the page's packages" VERBATIM)
  add_custom_command(OUTPUT ${page} COMMAND ${NPM} run --silent build
    DEPENDS ${viewer_sources} ${viewer}/build.mjs ${viewer_packages}
    WORKING_DIRECTORY ${viewer} COMMENT "Bundling the page" VERBATIM)
elseif(NOT EXISTS ${page})
  message(FATAL_ERROR "viewer/dist/page.html is missing and npm, which builds it, was not found: "
    "install nodejs and npm (Debian: apt-get install nodejs npm), or build the page elsewhere with "
    "`cd viewer && npm ci && npm run build` and copy viewer/dist here")
endif()
set_source_files_properties(inhabit/view/page_template.cpp PROPERTIES
  OBJECT_DEPENDS ${page} SKIP_PRECOMPILE_HEADERS ON COMPILE_DEFINITIONS "INHABIT_PAGE_TEMPLATE=\"${page}\"")
