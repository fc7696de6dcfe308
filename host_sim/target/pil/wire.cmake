# SPDX-License-Identifier: Apache-2.0
# pil_wire: the wire between camsim and a target, with a fingerprint of every header that says what
# goes over it. Both sides compare, so an image of other sources is found out and not believed.
file(GLOB wire_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/firmware/*/*.h)
list(APPEND wire_headers
    ${PROJECT_SOURCE_DIR}/hal/include/hal/hal.h ${CMAKE_CURRENT_LIST_DIR}/pil_wire.h)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${wire_headers})

set(wire_hashes "")
foreach(header IN LISTS wire_headers)
    file(SHA256 ${header} hash)
    string(APPEND wire_hashes ${hash})
endforeach()
string(SHA256 wire_hash ${wire_hashes})
string(SUBSTRING ${wire_hash} 0 8 wire_hash)

add_library(pil_wire INTERFACE)
target_include_directories(pil_wire INTERFACE ${CMAKE_CURRENT_LIST_DIR})
target_compile_definitions(pil_wire INTERFACE PIL_HEADERS=0x${wire_hash}u)
