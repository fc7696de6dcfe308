# cam_room(NAME [DEPENDS ROOM ...] [USES TARGET ...]): the sources of this folder as a library of
# their own, one room of the house.
#
# A room's folder is its include path, and include paths follow links, so a room sees the headers
# of the rooms it names in DEPENDS and of those below them, and no others: an #include that points
# upward finds no file. USES are targets whose headers the room's own headers do not show.
function(cam_room name)
    cmake_parse_arguments(PARSE_ARGV 1 room "" "" "DEPENDS;USES")
    file(GLOB sources CONFIGURE_DEPENDS *.c)
    add_library(${name} STATIC ${sources})
    target_include_directories(${name} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${name} PUBLIC ${room_DEPENDS} PRIVATE ${room_USES} cam_warnings)
    cam_lto_objects(${name})
endfunction()
