# Target api_reference: the pages build/<preset>/api_reference/html, of the docstrings of the public headers. These are
# what a program includes that computes forces, brings a device, has the server inside or speaks to one; every other
# header is a folder's own. A warning is an error: wrong parameter names, links that lead nowhere.
find_package(Doxygen REQUIRED)

set(public_headers
  # Values that all of it is made of.
  common/error/error.h
  common/hash/content_hash.h
  common/maths/vec.h
  common/telemetry/device_status.h
  common/telemetry/energy_state.h
  common/telemetry/motion_state.h
  common/telemetry/telemetry_sample.h
  # A program with a loop and a device of its own.
  haptic_server/world/world.h
  # The step and its scene.
  common/deform/dent.h
  common/deform/soft_tissue.h
  common/mesh/generators.h
  common/mesh/import.h
  common/mesh/tri_mesh.h
  common/surface/make_field.h
  common/surface/scalar_field.h
  haptic_server/engine/contact/contact.h
  haptic_server/engine/geometry/collision_mesh.h
  haptic_server/engine/motion/rigid_body.h
  haptic_server/engine/step/haptic_state.h
  haptic_server/engine/step/haptic_step.h
  haptic_server/servo/server_step_config.h
  haptic_server/engine/step/servo_scene.h
  haptic_server/engine/surface/surface_detail.h
  # A device.
  haptic_server/device/plugin/device_plugin.h
  haptic_server/device/device.h
  haptic_server/device/usb/usb_protocol.h
  # The whole server.
  haptic_server/server_app.h
  haptic_server/server_options.h
  # A client.
  common/credentials/credentials.h
  common/scene/deformation_properties.h
  common/scene/motion_properties.h
  common/scene/scene.h
  common/scene/surface_edits.h
  common/scene/surface_properties.h
  common/wire/convert.h
  common/wire/endpoint.h
  common/wire/event_loop.h
  common/wire/transport.h
  graphics_client/mirror/client_callbacks.h
  graphics_client/mirror/mirror_view.h
  graphics_client/mirror/server_link.h)
list(TRANSFORM public_headers PREPEND ${PROJECT_SOURCE_DIR}/)

set(DOXYGEN_PROJECT_BRIEF
  "Begin with World to compute forces, Device to bring hardware, ServerApp for the server, ServerLink for a client")
set(DOXYGEN_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/api_reference)
set(DOXYGEN_STRIP_FROM_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_STRIP_FROM_INC_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_FULL_PATH_NAMES YES)
set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
set(DOXYGEN_EXTRACT_ALL YES)  # a name that says it all has no docstring
set(DOXYGEN_BUILTIN_STL_SUPPORT YES)  # for specialisations of std::hash
set(DOXYGEN_SHOW_USED_FILES NO)
set(DOXYGEN_WARN_IF_INCOMPLETE_DOC NO)  # only parameters that need words have them
set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
set(DOXYGEN_QUIET YES)
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_GENERATE_LATEX NO)
doxygen_add_docs(api_reference ${public_headers} COMMENT "Writing ${DOXYGEN_OUTPUT_DIRECTORY}/html/index.html")
