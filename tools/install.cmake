# `cmake --install`: the program, the libraries with their headers as a CMake package, the shipped scenes.
#
#     find_package(haarfield) gives haarfield::fields, ::shading, ::scenes and ::bridge.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/haarfield)
set(libraries fields shading scenes bridge)

foreach(library IN LISTS libraries)
    set_target_properties(haarfield_${library} PROPERTIES EXPORT_NAME ${library})
    target_include_directories(haarfield_${library} INTERFACE
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/haarfield>)
    install(TARGETS haarfield_${library} EXPORT haarfieldTargets ARCHIVE)
endforeach()
install(CODE "set(SOURCE \"${PROJECT_SOURCE_DIR}\")
set(LIBRARIES \"${libraries}\")
set(DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/haarfield\")")
install(SCRIPT tools/install_headers.cmake)

# Exported targets must include the flags that the static libraries are linked with; they require nothing of
# users.
install(TARGETS haarfield_flags EXPORT haarfieldTargets)
set_target_properties(haarfield_flags PROPERTIES EXPORT_NAME flags)
install(EXPORT haarfieldTargets NAMESPACE haarfield:: DESTINATION ${package_folder})

configure_package_config_file(tools/haarfieldConfig.cmake.in haarfieldConfig.cmake
    INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(haarfieldConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/haarfieldConfig.cmake ${PROJECT_BINARY_DIR}/haarfieldConfigVersion.cmake
    DESTINATION ${package_folder})

install(TARGETS haarfield RUNTIME)
if(TARGET haarfield-reader)
    install(TARGETS haarfield-reader haarfield-image-reader RUNTIME)
endif()
install(FILES ${PROJECT_BINARY_DIR}/pages/haarfield.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_BINARY_DIR}/pages/haarfield DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(DIRECTORY scenes/ DESTINATION ${CMAKE_INSTALL_DATADIR}/haarfield/scenes
    FILES_MATCHING PATTERN "*.toml" PATTERN "*.obj")
if(TARGET haarfield_addon)
    install(FILES ${HAARFIELD_ADDON} DESTINATION ${CMAKE_INSTALL_DATADIR}/haarfield)
endif()
install(FILES LICENSE README.md CHANGELOG.md SECURITY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES .reuse/dep5 DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
