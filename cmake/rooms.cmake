# glowworm_room(NAME USES rooms… LIBRARIES private libraries…)
# A room is one static library made of all .cc files below its folder. USES are the rooms its headers may
# include (the arrows of docs/architecture.md); LIBRARIES are what only its own files see.
function(glowworm_room name)
  cmake_parse_arguments(ROOM "" "" "USES;LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cc)
  list(FILTER sources EXCLUDE REGEX "/image/reader/")           # a program of its own
  list(FILTER sources EXCLUDE REGEX "/image/ocio/")            # a module of its own
  list(FILTER sources EXCLUDE REGEX "/share/mpi/")             # another module
  list(FILTER sources EXCLUDE REGEX "/import/assimp/reader/")  # another program
  list(FILTER sources EXCLUDE REGEX "/import/openvdb/reader/") # a third
  list(TRANSFORM ROOM_USES PREPEND glowworm_)
  if(sources)
    add_library(glowworm_${name} STATIC ${sources})
    target_link_libraries(glowworm_${name} PUBLIC glowworm_options ${ROOM_USES} PRIVATE ${ROOM_LIBRARIES})
  else()
    add_library(glowworm_${name} INTERFACE)
    target_link_libraries(glowworm_${name} INTERFACE glowworm_options ${ROOM_USES})
  endif()
endfunction()
