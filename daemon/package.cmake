# SPDX-License-Identifier: Apache-2.0
# What is installed where, and the Debian package of it: cpack -G DEB in a build folder.
include(GNUInstallDirs)
install(TARGETS geon geond RUNTIME DESTINATION bin)
install(FILES ${PROJECT_SOURCE_DIR}/config/geond.toml ${PROJECT_SOURCE_DIR}/config/sim.toml DESTINATION /etc/geond)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/config/scenes ${PROJECT_SOURCE_DIR}/config/drives DESTINATION /etc/geond
        FILES_MATCHING PATTERN "*.toml")
install(FILES ${PROJECT_SOURCE_DIR}/systemd/geond.service ${PROJECT_SOURCE_DIR}/systemd/geond.socket DESTINATION /lib/systemd/system)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/grafana_dashboard.json ${PROJECT_SOURCE_DIR}/docs/operating.md ${PROJECT_SOURCE_DIR}/docs/api.md
        DESTINATION share/doc/geond)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/geond.sysusers DESTINATION /usr/lib/sysusers.d RENAME geond.conf)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/geond.tmpfiles DESTINATION /usr/lib/tmpfiles.d RENAME geond.conf)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/60-geond.rules DESTINATION /lib/udev/rules.d)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/geon.bash-completion DESTINATION share/bash-completion/completions RENAME geon)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/robots DESTINATION share/doc/geond)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/debian/copyright DESTINATION share/doc/geond)
install(FILES ${PROJECT_SOURCE_DIR}/systemd/debian/lintian-overrides DESTINATION share/lintian/overrides RENAME geond)

install(DIRECTORY ${CMAKE_BINARY_DIR}/page/ DESTINATION share/geond/page FILES_MATCHING PATTERN "*.js" PATTERN "*.css" PATTERN "*.html"
        PATTERN npm EXCLUDE)

find_program(GZIP gzip)
foreach(page geon.1 geond.8)
  string(REGEX REPLACE ".*\\." "" section ${page})
  add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${page}.gz
                     COMMAND ${GZIP} -9nc ${PROJECT_SOURCE_DIR}/docs/man/${page} > ${CMAKE_CURRENT_BINARY_DIR}/${page}.gz
                     DEPENDS ${PROJECT_SOURCE_DIR}/docs/man/${page})
  list(APPEND man_pages ${CMAKE_CURRENT_BINARY_DIR}/${page}.gz)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${page}.gz DESTINATION share/man/man${section})
endforeach()
add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz
                   COMMAND ${GZIP} -9nc ${PROJECT_SOURCE_DIR}/systemd/debian/changelog > ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz
                   DEPENDS ${PROJECT_SOURCE_DIR}/systemd/debian/changelog)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz DESTINATION share/doc/geond)
add_custom_target(man_pages ALL DEPENDS ${man_pages} ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME geond)
set(CPACK_PACKAGE_CONTACT "geond developers <geond@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "adduser, systemd")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "geond runs a scanning station: it turns an object, takes range images of
it, and describes it as a few parametric parts with their poses. geon is
the command for people and scripts; robots ask over a socket. Without
hardware it runs a simulated station.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/systemd/debian/postinst ${PROJECT_SOURCE_DIR}/systemd/debian/prerm
    ${PROJECT_SOURCE_DIR}/systemd/debian/postrm ${PROJECT_SOURCE_DIR}/systemd/debian/conffiles)
include(CPack)
