# What `cmake --install` puts below a prefix, and the Debian package that CPack makes of it. PREFIX/share/hotbed is a part of
# the source tree, so that paths and links in it hold.
include(GNUInstallDirs)
set(tree ${CMAKE_INSTALL_DATADIR}/hotbed)

set_target_properties(hotbedFoam PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
install(TARGETS hotbedFoam hotbed_liggghts)
install(PROGRAMS hotbed DESTINATION ${tree})
install(CODE "file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
  file(CREATE_LINK ../${tree}/hotbed \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}/hotbed\" SYMBOLIC)")
install(DIRECTORY cfd_solver DESTINATION ${tree} FILES_MATCHING PATTERN "*.py" PATTERN tests EXCLUDE)
install(DIRECTORY examples docs DESTINATION ${tree} PATTERN __pycache__ EXCLUDE)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${tree})
# what pictures and reports are made with
foreach(script campaign report report_errors report_page report_run report_run_page results schumann)
  install(FILES validation/${script}.py DESTINATION ${tree}/validation)
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)

# LIGGGHTS and OpenFOAM of the very versions that this was built with: their classes are part of our code. OpenFOAM's
# libraries have no version in their names from which dpkg-shlibdeps could tell.
foreach(package libopenfoam libliggghts3 libopenmpi3 libstdc++6 libc6)
  execute_process(COMMAND dpkg-query -W -f "\${Version}" ${package} OUTPUT_VARIABLE version COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "-[^-]*$" "" upstream ${version})
  list(APPEND depends "${package} (>= ${upstream})")
  if(package MATCHES "openfoam|liggghts")
    list(APPEND depends "${package} (<< ${upstream}.)")
  endif()
endforeach()
list(APPEND depends openfoam liggghts openmpi-bin python3 python3-numpy python3-scipy python3-matplotlib)
list(JOIN depends ", " CPACK_DEBIAN_PACKAGE_DEPENDS)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_NAME hotbed)
set(CPACK_PACKAGE_CONTACT "Hotbed <hotbed@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "coarse-grained CFD-DEM with heat for fluidised beds")
set(CPACK_PACKAGE_DESCRIPTION "LIGGGHTS computes the particles, OpenFOAM the gas, Hotbed joins them on the same MPI ranks.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
include(CPack)
