# The Debian package of tools/package: everything that `cmake --install` installs, for this distribution.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME haarfield)
set(CPACK_PACKAGE_CONTACT "The haarfield authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "bake light into the vertex colours of POV-Ray meshes")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
# dpkg-shlibdeps adds the libraries. These packages are used at run time by name.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "povray, libjs-three, python3-numpy")
# The sandbox in which POV-Ray reads scenes, and the include files that scenes use.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "bubblewrap, povray-includes")
if(HAARFIELD_PYTHON_MINOR)
    math(EXPR next_minor "${HAARFIELD_PYTHON_MINOR} + 1")
    string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS
        ", python3 (>= 3.${HAARFIELD_PYTHON_MINOR}), python3 (<< 3.${next_minor})")
endif()
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "blender, ffmpeg, parallel, slurm-client")
include(CPack)
