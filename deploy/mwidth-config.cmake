# find_package(mwidth)                     mwidth::model, the mathematics alone: no gRPC, no protobuf
# find_package(mwidth COMPONENTS client)   mwidth::client besides
include(CMakeFindDependencyMacro)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/mwidth-model.cmake OPTIONAL RESULT_VARIABLE mwidth_model_FOUND)
if("client" IN_LIST mwidth_FIND_COMPONENTS)
  find_dependency(Protobuf MODULE) # module mode: its imported targets are what gRPC's package expects
  find_dependency(gRPC CONFIG)
  include(${CMAKE_CURRENT_LIST_DIR}/mwidth-client.cmake OPTIONAL RESULT_VARIABLE mwidth_client_FOUND)
endif()
foreach(component IN LISTS mwidth_FIND_COMPONENTS)
  if(NOT mwidth_${component}_FOUND)
    set(mwidth_FOUND FALSE)
    set(mwidth_NOT_FOUND_MESSAGE "mwidth is installed without its component ${component}")
  endif()
endforeach()
