# What `cmake --install` installs: the program, the libraries with their headers, man page, completion, licence.
#
# Each static library is one archive made of the rooms that it needs, so that the rooms themselves stay inside. The
# shared library holds all of them, and exports the public interface alone.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# glowworm_archive(NAME rooms…): libNAME.a of the objects of rooms
function(glowworm_archive name)
  list(TRANSFORM ARGN PREPEND glowworm_ OUTPUT_VARIABLE rooms)
  set(archive ${CMAKE_BINARY_DIR}/lib/lib${name}.a)
  set(script "CREATE ${archive}\n")
  foreach(room ${rooms})
    string(APPEND script "ADDLIB $<TARGET_FILE:${room}>\n")
  endforeach()
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/lib/${name}.mri CONTENT "${script}SAVE\nEND\n")
  # Without what scripts/check-odr compares, or every link of the archive would optimise all of it anew.
  add_custom_command(OUTPUT ${archive} COMMAND ${CMAKE_AR} -M < ${CMAKE_BINARY_DIR}/lib/${name}.mri
    COMMAND ${CMAKE_OBJCOPY} -R .gnu.lto_* -R .gnu.debuglto_* -N __gnu_lto_v1 ${archive}
    DEPENDS ${rooms} ${CMAKE_BINARY_DIR}/lib/${name}.mri VERBATIM)
  add_custom_target(archive_${name} ALL DEPENDS ${archive})
  install(FILES ${archive} DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()

set(density_rooms density points bsdf kernels core)
set(GLOWWORM_DENSITY_LIBRARIES tbb fmt hwy)
set(GLOWWORM_LIBRARIES embree3 OpenEXR-3_1 Iex-3_1 IlmThread-3_1 Imath-3_1 png tinygltf draco meshoptimizer z zstd dl)
glowworm_archive(glowworm_density ${density_rooms})
glowworm_archive(glowworm api gltf_writer bake measure control share film maps settings filter gather photon transport trace import builtin scene image)

add_library(glowworm_shared SHARED $<TARGET_OBJECTS:glowworm_api> $<TARGET_OBJECTS:glowworm_density>)
target_link_libraries(glowworm_shared PRIVATE glowworm_api)
set(exports ${CMAKE_SOURCE_DIR}/cmake/exports.map)
target_link_options(glowworm_shared PRIVATE LINKER:--version-script=${exports} LINKER:--no-undefined)
set_target_properties(glowworm_shared PROPERTIES OUTPUT_NAME glowworm LINK_DEPENDS ${exports}
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib
  BUILD_RPATH ${CMAKE_RUNTIME_OUTPUT_DIRECTORY} INSTALL_RPATH "$ORIGIN/glowworm")
install(TARGETS glowworm_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})

install(DIRECTORY ${CMAKE_SOURCE_DIR}/include/glowworm DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS glowworm RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS glowworm_mpi glowworm_ocio LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/glowworm)
set_target_properties(glowworm PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}/glowworm")
install(TARGETS glowworm_reader glowworm_assimp glowworm_openvdb RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/glowworm)

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/glowwormConfig.cmake.in ${CMAKE_BINARY_DIR}/lib/glowwormConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/glowworm PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/lib/glowwormConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/lib/glowwormConfig.cmake ${CMAKE_BINARY_DIR}/lib/glowwormConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/glowworm)
list(TRANSFORM GLOWWORM_DENSITY_LIBRARIES PREPEND -l OUTPUT_VARIABLE density_flags)
list(TRANSFORM GLOWWORM_LIBRARIES PREPEND -l OUTPUT_VARIABLE library_flags)
list(JOIN density_flags " " GLOWWORM_DENSITY_FLAGS)
list(JOIN library_flags " " GLOWWORM_FLAGS)
configure_file(${CMAKE_SOURCE_DIR}/cmake/glowworm.pc.in ${CMAKE_BINARY_DIR}/lib/glowworm.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/lib/glowworm.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# Made from the program's own help, so that they cannot differ from it.
set(man ${CMAKE_BINARY_DIR}/lib/glowworm.1)
set(completion ${CMAKE_BINARY_DIR}/lib/glowworm.bash)
add_custom_command(OUTPUT ${man} ${completion}
  COMMAND ${CMAKE_SOURCE_DIR}/scripts/make-man-page ${man} ${completion} ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:glowworm>
  DEPENDS glowworm ${CMAKE_SOURCE_DIR}/scripts/make-man-page VERBATIM)
add_custom_target(man ALL DEPENDS ${man} ${completion})
install(FILES ${man} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME glowworm)
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_NAME glowworm)
set(CPACK_PACKAGE_VENDOR Glowworm)
set(CPACK_PACKAGE_CONTACT "Glowworm's authors <glowworm@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Global illumination renderer built on photon maps")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "libembree-dev, libtbb-dev, libhwy-dev, libfmt-dev, libopenexr-dev, libpng-dev, libtinygltf-dev, libdraco-dev, libmeshoptimizer-dev, libzstd-dev")
include(CPack)
