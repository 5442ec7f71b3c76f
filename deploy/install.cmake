# cmake --install: programs in a folder of their own, where each finds the ones beside it, and links to those that people
# start in bin. A component for each Debian package (deploy/debian).
set(programs_folder ${CMAKE_INSTALL_LIBDIR}/haptics)
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
  WORLD_EXECUTE)

file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/links)

# install_programs(<component> PROGRAMS <in the folder>... STARTED <linked in bin>...)
function(install_programs component)
  cmake_parse_arguments(ARG "" "" "PROGRAMS;STARTED" ${ARGN})
  foreach(program IN LISTS ARG_PROGRAMS ARG_STARTED)
    install(TARGETS ${program} RUNTIME DESTINATION ${programs_folder} COMPONENT ${component})
  endforeach()
  foreach(program IN LISTS ARG_STARTED)
    file(CREATE_LINK ../${programs_folder}/${program} ${CMAKE_BINARY_DIR}/links/${program} SYMBOLIC)
    install(FILES ${CMAKE_BINARY_DIR}/links/${program} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
    install(FILES deploy/completion/haptics.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
      RENAME ${program} COMPONENT ${component})
  endforeach()
endfunction()

install_programs(server PROGRAMS haptic_watchdog asset_importer inventor_importer assimp_importer STARTED haptic_server)
install(FILES deploy/udev/70-haptic-devices.rules DESTINATION lib/udev/rules.d COMPONENT server)
install(FILES deploy/systemd/haptic_server.service DESTINATION lib/systemd/system COMPONENT server)
file(GLOB scenes CONFIGURE_DEPENDS deploy/scenes/*.scene deploy/scenes/*.png)
install(FILES ${scenes} DESTINATION ${CMAKE_INSTALL_DATADIR}/haptics/scenes COMPONENT server)

install_programs(viewer STARTED graphics_client)

install_programs(tools STARTED hapticctl haptic_igtl haptic_relay mesh_report)
if(TARGET haptic_ros2)
  install_programs(tools STARTED haptic_ros2)
endif()
if(HAPTICS_TESTS)
  install_programs(tools STARTED haptic_eval)
  install(FILES tests/eval/figure/eval_figures.py DESTINATION ${programs_folder} COMPONENT tools)
endif()
set(python_folder lib/python3/dist-packages)
install(DIRECTORY ${CMAKE_BINARY_DIR}/python/ DESTINATION ${python_folder} COMPONENT python
  FILES_MATCHING PATTERN "*.py" PATTERN "_world.*so" PATTERN "__pycache__" EXCLUDE)
