# What mwidth::client links, then itself.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(Protobuf MODULE) # module mode: its imported targets are what gRPC's package expects
find_dependency(gRPC CONFIG)
include(${CMAKE_CURRENT_LIST_DIR}/mwidth-targets.cmake)
