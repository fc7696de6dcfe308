# What tools/pyproject.toml adds to the modules of the Python package: the simulator, and the files of
# the project that commands read, at the same places as in a clone (tools/camtools/base/project.py).
set(wheel COMPONENT wheel EXCLUDE_FROM_ALL)
foreach(file IN ITEMS firmware/FAULTS.md firmware/base/cam_err.h firmware/param/cam_param.h firmware/remote/can/camturn.dbc
        LICENSE hal/include/hal/version.h tools/docs/CAMS.md tools/docs/PARTFILE.md tools/docs/POLYGONS.md)
    cmake_path(GET file PARENT_PATH folder)
    install(FILES ${file} DESTINATION ./${folder} ${wheel})
endforeach()
install(DIRECTORY tools/parts DESTINATION tools ${wheel})
install(DIRECTORY host_sim/machines DESTINATION host_sim ${wheel})
install(TARGETS camsim camsim_library judge_library DESTINATION build/host/host_sim ${wheel})
